//! Commands of a program from its command line.

use clap::Parser;

/// The command that was given; ends the program if there is none. A negative number is a value, which an option may
/// refuse by its range, and not another option.
pub fn given<C: Parser>() -> C {
    let command = C::command().mut_subcommands(|subcommand| {
        subcommand.mut_args(|option| match option.get_action().takes_values() && !option.is_positional() {
            true => option.allow_negative_numbers(true),
            false => option,
        })
    });
    C::from_arg_matches(&command.get_matches()).unwrap_or_else(|error| error.exit())
}
