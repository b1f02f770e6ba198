//! The plain records: every type that this crate casts from and to bytes is declared here, by one macro.
//!
//! The derive macros of `bytemuck` would do the same at the cost of five more crates for everyone who opens a file.

/// Declare types as plain old data.
///
/// Each type is listed with the types of all its fields in order. The macro proves at compile time what the argument below needs: the sizes of
/// the fields add up to the size of the type, so that there is no padding, and every field is itself plain old data.
macro_rules! plain {
    ($($(#[$why:meta])* $name:ty = [$($field:ty),* $(,)?];)*) => {$(
        const _: () = {
            const fn is_plain<T: bytemuck::Pod>() {}
            $(is_plain::<$field>();)*
            assert!(0 $(+ size_of::<$field>())* == size_of::<$name>(), "the type has padding, or a field is not listed");
        };
        // SAFETY: any bytes, so also zeros, are a value of each field, which is `Pod`; there is nothing but the fields.
        #[allow(unsafe_code)]
        unsafe impl bytemuck::Zeroable for $name {}
        // SAFETY: the type is `repr(C)` or `repr(transparent)`, as its declaration beside the macro's use shows. All fields are `Pod` and
        // there is no padding, as the constant above proves. It is `Copy` and `'static`, which the trait itself demands.
        #[allow(unsafe_code)]
        unsafe impl bytemuck::Pod for $name {}
    )*};
}
pub(crate) use plain;
