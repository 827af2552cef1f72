//! Operators that do the same to each lane.

/// Implements operators by an intrinsic where the build has the feature, and by a function of two scalars
/// where it has not.
macro_rules! lanewise {
    ($Lanes:ident, $feature:tt: $($Trait:ident $method:ident $intrinsic:ident $scalar:path;)*) => {$(
        impl $Trait for $Lanes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                #[cfg(target_feature = $feature)]
                return Self(unsafe { $intrinsic(self.0, other.0) });
                #[cfg(not(target_feature = $feature))]
                return Self(std::array::from_fn(|i| $scalar(self.0[i], other.0[i])));
            }
        }
    )*};
}
pub(super) use lanewise;
