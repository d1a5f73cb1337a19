//! Every law of this crate conforms, and the suite finds what is wrong with others.

mod laws {
    use sinew_energy::Guard;
    use sinew_energy::Law;
    use sinew_energy::conformance::*;
    use sinew_energy::laws::{
        ActiveTension, ByYoungPoisson, Compressible, Guccione, HolzapfelOgden, HolzapfelOgden2009,
        HolzapfelOgdenCompressible, LinearElastic, NeoHookean, NeoHookeanShape,
    };
    use sinew_energy::{Solid, Strain};
    use sinew_num::Mat3;
    use sinew_num::Scalar;

    /// An orthonormal frame off the axes.
    const FRAME: [[f64; 3]; 3] = [
        [2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0],
        [-2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0],
        [1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0],
    ];
    const SOLID: Claims =
        Claims { stress_free_at_rest: true, objective: true, positive_volume: true };
    const SMALL_DISPLACEMENT: Claims =
        Claims { stress_free_at_rest: true, objective: false, positive_volume: false };
    const BULK: f64 = 5.0;

    fn holds<L: Law<D>, const D: usize>(law: L, parameters: &[f64], claims: Claims) {
        let directions = std::array::from_fn(|d| FRAME[d]);
        if let Err(failures) = check_law(&law, parameters, &directions, claims, 7) {
            let lines: Vec<_> = failures.iter().take(8).map(Failure::to_string).collect();
            panic!("{} failures\n{}", failures.len(), lines.join("\n"));
        }
    }

    #[test]
    fn every_law_conforms() {
        holds(NeoHookean, &[1.5, 2.5], SOLID);
        holds(ByYoungPoisson(NeoHookean), &[10.0, 0.3], SOLID);
        holds(NeoHookeanShape.nearly_incompressible(BULK), &[1.5], SOLID);
        holds(LinearElastic, &[1.5, 2.5], SMALL_DISPLACEMENT);
        holds(HolzapfelOgden.nearly_incompressible(BULK), &[0.18, 2.6, 3.34, 2.73], SOLID);
        let compressible = Solid::new(HolzapfelOgdenCompressible, Compressible { kappa: 25.0 });
        holds(compressible, &[0.18, 2.6, 3.34, 2.73], SOLID);
        let orthotropic = [0.059, 8.023, 18.472, 16.026, 2.481, 11.12, 0.216, 11.436];
        holds(HolzapfelOgden2009.nearly_incompressible(BULK), &orthotropic, SOLID);
        holds(Guccione.nearly_incompressible(BULK), &[2.0, 8.0, 2.0, 4.0], SOLID);
        let whole = Solid { strain: Strain::Whole, ..Guccione.nearly_incompressible(BULK) };
        holds(whole, &[2.0, 8.0, 2.0, 4.0], SOLID);
        holds(Solid::new(NeoHookeanShape, Compressible { kappa: BULK }), &[1.5], SOLID);
        let contracting = Claims { stress_free_at_rest: false, ..SOLID };
        let muscle = HolzapfelOgden.nearly_incompressible(BULK);
        holds(muscle.with_active(ActiveTension), &[0.18, 2.6, 3.34, 2.73, 4.0], contracting);
    }

    /// `Ψ = ½μ(I₁ − 3)` from F itself: stressed at rest, blind to inversion, and poor in single precision.
    #[derive(Clone, Debug)]
    struct Faulty;

    impl Law<0> for Faulty {
        const NAME: &'static str = "faulty";
        const PARAMETERS: &'static [&'static str] = &["mu"];

        fn density<S: Scalar, G: Guard>(
            &self,
            parameters: &[S],
            displacement_gradient: &Mat3<S>,
            _directions: &[[S; 3]; 0],
            _guard: &G,
        ) -> S {
            let h = displacement_gradient;
            let f = Mat3::from_fn(|i, j| h.at(i, j) + if i == j { 1.0 } else { 0.0 });
            parameters[0].clone() * (f.squared_norm() - 3.0) * 0.5
        }

        fn stress<G: Guard>(
            &self,
            parameters: &[f64],
            displacement_gradient: &Mat3<f64>,
            directions: &[[f64; 3]; 0],
            guard: &G,
        ) -> (f64, Mat3<f64>) {
            let h = displacement_gradient;
            let energy = self.density(parameters, h, directions, guard);
            (energy, Mat3::from_fn(|i, j| parameters[0] * h[i][j]))
        }
    }

    #[test]
    fn faults_are_found() {
        let failures = check_law(&Faulty, &[1.0], &[], Claims::default(), 7).unwrap_err();
        for property in [
            "the stress at rest is zero",
            "rotation turns the stress with it",
            "the stress agrees with Taylor numbers",
            "the stress agrees with differences of the energy",
            "the energy keeps its digits at small strain",
            "the energy is infinite at J <= 0",
        ] {
            assert!(failures.iter().any(|f| f.property == property), "{property} not found");
        }
        assert!(failures.iter().all(|f| !f.property.contains("energy at rest")));
        assert!(check_law(&NeoHookean, &[-1.0, 1.0], &[], Claims::default(), 7).is_err());
    }
}
