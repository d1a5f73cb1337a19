//! Generic functions that are compiled here for one to three axes, and not again in every program that calls them.

/// The instance for `D` axes of a generic function `Type::function`, with its type. The instances are those of a
/// static of this crate, so that a caller links to them. A domain has three axes at most.
macro_rules! instance {
    ($D:ident, $owner:ident::$function:ident, $signature:ty) => {{
        type Signature<const $D: usize> = $signature;
        static INSTANCES: (Signature<1>, Signature<2>, Signature<3>) =
            ($owner::<1>::$function, $owner::<2>::$function, $owner::<3>::$function);
        let all: [&dyn std::any::Any; 3] = [&INSTANCES.0, &INSTANCES.1, &INSTANCES.2];
        let own = all.into_iter().find_map(|instance| instance.downcast_ref::<Signature<$D>>());
        *own.expect("one to three axes")
    }};
}
