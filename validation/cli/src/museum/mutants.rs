//! Mutants: small changes at every place of a file where they can be made, and a random sample of them.

use super::plant::Change;
use proc_macro2::Span;
use std::ops::Range;
use std::path::Path;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, Lit, UnOp};
use validation::statistics::seed_for;

/// A sample of `count` mutants of the files whose paths, relative to the root of the repository, begin with
/// one of `paths`. Another `number` gives another sample.
pub fn sample(root: &Path, paths: &[String], count: usize, number: u64) -> Result<Vec<Change>, String> {
    let mut files = vec![];
    paths.iter().try_for_each(|path| list(&root.join(path), &mut files))?;
    files.sort();
    files.dedup();
    let mut all = vec![];
    for path in files {
        let file = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{file}: {e}"))?;
        all.extend(of_file(&file, &text)?);
    }
    // Sorting by a hash shuffles without a generator.
    all.sort_by_cached_key(|mutant| seed_for(&mutant.name, number));
    let (mut chosen, _) = super::plant::apart(all);
    chosen.truncate(count);
    Ok(chosen)
}

fn list(path: &Path, files: &mut Vec<std::path::PathBuf>) -> Result<(), String> {
    if path.is_dir() {
        let entries = std::fs::read_dir(path).map_err(|e| format!("{}: {e}", path.display()))?;
        return entries.filter_map(Result::ok).try_for_each(|entry| list(&entry.path(), files));
    }
    let tests = ["tests.rs", "contract.rs", "prism.rs"].map(Some);
    let name = path.file_name().and_then(|name| name.to_str());
    if !tests.contains(&name) && name.is_some_and(|name| name.ends_with(".rs")) {
        files.push(path.to_owned());
    }
    Ok(())
}

/// All mutants of a file.
pub fn of_file(file: &str, text: &str) -> Result<Vec<Change>, String> {
    let parsed = syn::parse_file(text).map_err(|e| format!("{file}: {e}"))?;
    let mut finder = Finder { file, text, found: vec![] };
    finder.visit_file(&parsed);
    Ok(finder.found)
}

struct Finder<'a> {
    file: &'a str,
    text: &'a str,
    found: Vec<Change>,
}

impl Finder<'_> {
    /// Adds a mutant in which `part` of the expression `whole` is replaced.
    fn replace(&mut self, whole: Range<usize>, part: Range<usize>, by: &str) {
        let text = self.text;
        let replace = [&text[whole.start..part.start], by, &text[part.end..whole.end]].concat();
        let line = 1 + text[..whole.start].matches('\n').count();
        let short = |code: &str| code.split_whitespace().collect::<Vec<_>>().join(" ");
        let (right, wrong) = (short(&text[part]), short(by));
        let nth = self.found.iter().filter(|m| m.name.starts_with(&format!("{}:{line}#", self.file))).count();
        self.found.push(Change {
            name: format!("{}:{line}#{nth}", self.file),
            about: format!("`{right}` → `{wrong}` in `{}`", short(&text[whole.clone()])),
            source: String::new(),
            file: self.file.to_owned(),
            chapter: None,
            range: whole,
            replace,
        });
    }

    fn swap(&mut self, whole: Range<usize>, part: Span, pairs: &[(&str, &str)]) {
        let part = bytes(part);
        let found = self.text[part.clone()].to_owned();
        for (a, b) in pairs {
            if found == *a {
                self.replace(whole.clone(), part.clone(), b);
            } else if found == *b {
                self.replace(whole.clone(), part.clone(), a);
            }
        }
    }
}

fn bytes(span: Span) -> Range<usize> {
    span.byte_range()
}

fn holds_let(condition: &Expr) -> bool {
    struct Search(bool);
    impl Visit<'_> for Search {
        fn visit_expr_let(&mut self, _: &syn::ExprLet) {
            self.0 = true;
        }
    }
    let mut search = Search(false);
    search.visit_expr(condition);
    search.0
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|a| a.path().is_ident("cfg") || a.path().is_ident("test"))
}

const OPERATORS: [(&str, &str); 6] =
    [("+", "-"), ("*", "/"), ("<", "<="), (">", ">="), ("==", "!="), ("&&", "||")];
const METHODS: [(&str, &str); 2] = [("min", "max"), ("sin", "cos")];
const LITERALS: [(&str, &str); 6] =
    [("0.0", "1.0"), ("1.0", "2.0"), ("2.0", "1.0"), ("0.5", "1.0"), ("4.0", "2.0"), ("0", "1")];

impl<'a> Visit<'a> for Finder<'_> {
    fn visit_expr_binary(&mut self, binary: &'a syn::ExprBinary) {
        let (whole, operator) = (bytes(binary.span()), binary.op.span());
        match binary.op {
            _ if holds_let(&Expr::Binary(binary.clone())) => {}
            // An assignment has an effect that may be left out.
            BinOp::AddAssign(_) | BinOp::MulAssign(_) | BinOp::SubAssign(_) | BinOp::BitAndAssign(_) => {
                self.replace(whole.clone(), whole, "()");
            }
            _ => self.swap(whole, operator, &OPERATORS),
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_if(&mut self, choice: &'a syn::ExprIf) {
        if !holds_let(&choice.cond) {
            let whole = bytes(choice.cond.span());
            let negated = format!("!({})", &self.text[whole.clone()]);
            self.replace(whole.clone(), whole, &negated);
        }
        visit::visit_expr_if(self, choice);
    }

    fn visit_expr_unary(&mut self, unary: &'a syn::ExprUnary) {
        if let UnOp::Neg(minus) = unary.op {
            self.replace(bytes(unary.span()), bytes(minus.span()), "");
        }
        visit::visit_expr_unary(self, unary);
    }

    fn visit_expr_method_call(&mut self, call: &'a syn::ExprMethodCall) {
        self.swap(bytes(call.span()), call.method.span(), &METHODS);
        visit::visit_expr_method_call(self, call);
    }

    fn visit_expr_call(&mut self, call: &'a syn::ExprCall) {
        if let Expr::Path(path) = &*call.func
            && let Some(last) = path.path.segments.last()
        {
            self.swap(bytes(call.span()), last.ident.span(), &METHODS);
        }
        visit::visit_expr_call(self, call);
    }

    fn visit_expr_lit(&mut self, literal: &'a syn::ExprLit) {
        if let Lit::Int(_) | Lit::Float(_) = literal.lit {
            let whole = bytes(literal.span());
            if let Some((_, by)) = LITERALS.iter().find(|(from, _)| *from == &self.text[whole.clone()]) {
                self.replace(whole.clone(), whole, by);
            }
        }
    }

    // Constants are evaluated before any bug is active; patterns and lengths are no expressions; tests are
    // not under test.
    fn visit_item_const(&mut self, _: &'a syn::ItemConst) {}
    fn visit_impl_item_const(&mut self, _: &'a syn::ImplItemConst) {}
    fn visit_pat(&mut self, _: &'a syn::Pat) {}
    fn visit_type(&mut self, _: &'a syn::Type) {}
    fn visit_generic_argument(&mut self, _: &'a syn::GenericArgument) {}
    fn visit_expr_repeat(&mut self, repeat: &'a syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_item_fn(&mut self, function: &'a syn::ItemFn) {
        if !is_test(&function.attrs) && function.sig.constness.is_none() {
            visit::visit_item_fn(self, function);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mutants_are_found_where_they_can_live() {
        let text = "const N: usize = 1 + 1;\nfn f(a: f64) -> f64 {\n    if a < 2.0 { -a.min(π) } else { [0.0; 4][0] }\n}\n\
                    #[cfg(test)]\nmod tests { fn g() { 1.0 + 2.0; } }";
        let found = of_file("f.rs", text).unwrap();
        let changed = |m: &Change| [&text[..m.range.start], &m.replace, &text[m.range.end..]].concat();
        for wrong in
            ["!(a < 2.0)", "a <= 2.0", "a < 1.0", "{ a.min", "a.max(π)", "[1.0; 4][0]", "[0.0; 4][1]"]
        {
            assert!(found.iter().any(|m| changed(m).contains(wrong)), "{wrong}: {found:?}");
        }
        assert_eq!(found.len(), 7);
    }

    #[test]
    fn a_sample_is_a_function_of_its_number() {
        let names = |number| {
            let sample = sample(&crate::museum::root(), &["src/bsdf".into()], 20, number).unwrap();
            sample.into_iter().map(|m| m.name).collect::<Vec<_>>()
        };
        assert_eq!(names(0), names(0));
        assert_ne!(names(0), names(1));
        assert_eq!(names(0).len(), 20);
    }
}
