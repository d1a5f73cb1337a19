"""A heart of your own: from the mesh of a segmentation to checked answers, and to the body at rest.

Here an ideal ventricle stands in for it: tetrahedra, and the triangles of its surfaces labelled by the field `surface`.
Run it with `python heart.py`; it takes less than a minute.
"""

import meshio
import numpy as np

from pysinew import Case

# Stands in for your segmentation.
ideal = Case.scene("IdealVentricle")
surfaces = {"endo": 1, "epi": 2, "base": 3}
triangles = [ideal.facet_sets[name] for name in surfaces]
labels = [np.full(len(each), surfaces[name]) for name, each in zip(surfaces, triangles)]
meshio.Mesh(
    ideal.points,
    [("tetra", ideal.cells)] + [("triangle", each) for each in triangles],
    cell_data={"surface": [np.zeros(len(ideal.cells), dtype=int)] + labels},
).write("heart.vtu")

# Your mesh, a law, fibres by rule, pressure inside, the base held.
mesh = meshio.read("heart.vtu")
case = Case(
    name="heart",
    mesh=mesh,
    law={"name": "holzapfel-ogden", "bulk_modulus": 25.0},
    fibres={"rule": {"endocardium": "surface:1", "epicardium": "surface:2", "base": "surface:3", "angles": [60.0, -60.0]}},
    loads=[{"pressure": "p", "facets": "surface:1"}],
    supports=[{"clamped": "surface:3"}],
    parameters={
        "a": [0.1, 0.26],
        "b": [1.0, 4.2],
        "a_f": [1.5, 5.18],
        "b_f": [1.0, 4.46],
        "p": {"range": [4.0, 10.0], "unit": "mmHg"},
    },
)
print(case)

# Twenty parameter sets to a relative error of 1e-3, each answer checked.
thetas = case.sample(20, seed=1)
answers = case.answers(thetas, accuracy=1e-3)
print(f"{np.sum(answers.within)} of {len(answers)} within 1e-3, by {answers.method}")
for theta, volume in list(zip(answers.theta, answers.volumes["surface:1"]))[:3]:
    print(f"  p = {theta[-1]:.2f} mmHg: volume {volume / 1e3:.1f} ml")
assert np.all(answers.within)

# Stress along the fibres of the first of them; `to_pyvista` draws it.
stresses = answers.stresses(0)
print(f"fibre stretch {stresses['fibre_stretch'].min():.2f} to {stresses['fibre_stretch'].max():.2f}")
print(answers.to_meshio(0, stresses=True))

# If the scan was taken at 6 mmHg, the body at rest is smaller.
theta = {"a": 0.18, "b": 2.6, "a_f": 3.3, "b_f": 2.7, "p": "6 mmHg"}
rest = case.unload(theta)
again = rest.case.solve(theta)
print(f"loaded from rest, a node is at most {rest.distance:.1e} mm off its image")
assert np.abs(rest.case.points + again.displacement - case.points).max() < 1e-3
