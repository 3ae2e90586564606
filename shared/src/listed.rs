//! Enums that know all their variants.

/// Gives an enum without fields a constant `ALL`: every variant, in the order in which they stand.
macro_rules! listed {
    (
        $(#[$attribute:meta])*
        pub enum $name:ident { $($(#[$of_variant:meta])* $variant:ident,)* }
    ) => {
        $(#[$attribute])*
        pub enum $name { $($(#[$of_variant])* $variant,)* }

        impl $name {
            /// Every one, in this order.
            pub const ALL: [Self; [$(stringify!($variant)),*].len()] = [$(Self::$variant),*];
        }
    };
}
pub(crate) use listed;
