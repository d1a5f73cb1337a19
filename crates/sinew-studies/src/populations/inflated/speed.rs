//! Times of the thesis' network on the thesis' mesh (Table 2.1).

use super::methods::{Data, PACE};
use super::ventricle::Ventricles;
use super::{ALL, VIRTUAL_NODES};
use crate::populations::options::Options;
use crate::populations::simulated::{Compared, Simulated};
use crate::populations::stage;
use crate::populations::targets::Targets;
use crate::populations::variant::{Inputs, Variant};
use anyhow::{Context, Result};
use sinew_report::{Block, Column, Distribution, Row, Section, Table};

/// The section of the report: answers for a shape that changes and for one that stays, beside the solver, all parameters 1.
pub(in crate::populations) fn section(options: &Options) -> Result<Section> {
    options.kept(&options.out.join(stage::SPEED).join("section.json"), || measured(options))
}

fn measured(options: &Options) -> Result<Section> {
    let options = &Options { full: !options.quick, ..options.clone() };
    let ventricles = Ventricles::new(options)?;
    let numbers = vec![0.0; ALL];
    let found = ventricles.at(&numbers, &[vec![1.0; 4]])?;
    let only =
        found.first().context("the mean ventricle has no equilibrium at all parameters 1")?;
    let one = std::slice::from_ref(only);
    let [coarse_s, solver_s] = ventricles.times(one)?;
    let compared = Compared {
        options,
        training: one,
        validation: one,
        unseen: one,
        targets: &Targets::absolute(),
        pace: PACE,
        simulation_s: solver_s,
        coarse_s,
    };
    let told = Inputs { numbers: ALL, coarse: false };
    let virtual_nodes = if options.quick { &[8][..] } else { VIRTUAL_NODES[1] };
    let (steps, latent) = if options.quick { (1, 8) } else { (5, 40) };
    let variant = Variant::new(steps, latent, virtual_nodes, told);
    let topology = ventricles.graph(virtual_nodes)?;
    let surrogate = compared.untrained(variant, &compared.data_set(&topology, told)?)?;
    let errors = only.distances(&compared.predicting(&surrogate, &topology, told)(only)?);
    let data = Data { ventricles: &ventricles, compared, solver_s };
    let [varies_s, stays_s] = data.answer_times(&variant, &surrogate)?;
    let mut table = Table::new(
        [Column::new("err_u", "mm").about("‖u − û‖ at every node; of an untrained network")],
        [Column::new("answer", "s").about("CPU time of one parameter set")],
        [],
    );
    for (method, errors, seconds) in [
        ("network, shape varies", errors.clone(), varies_s),
        ("network, shape stays", errors, stays_s),
        ("coarse solution", only.distances(&only.coarse.displacement), coarse_s),
        ("solver", vec![0.0], solver_s),
    ] {
        let errors = Distribution::of(errors).context("a ventricle without nodes")?;
        table.push(Row::new(method, errors, seconds)?)?;
    }
    let nodes = format!("{} nodes.", only.body.nodes);
    let about = "CPU times of one answer, all parameters 1. The network has random weights, on which times do not depend: its errors mean nothing.";
    let blocks = vec![Block::Text(about.into()), Block::Text(nodes), Block::Table(table)];
    Ok(Section { name: stage::SPEED.into(), title: "Times on the thesis' mesh".into(), blocks })
}
