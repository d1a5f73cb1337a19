"""A small program of a user, which `mypy --strict` reads."""

import numpy as np

from pysinew import Answers, Case, CaseError, Check, Emulator, MeshCheck, Posterior, Solutions


def largest(case: Case, stiffness: float) -> float:
    solutions: Solutions = case.solve({"mu": stiffness, "lambda": "12 kPa"})
    return float(np.max(solutions.magnitude))


def within(emulator: Emulator, count: int) -> int:
    answers: Answers = emulator.answers(emulator.case.sample(count, seed=1), accuracy=1e-3)
    return int(np.sum(answers.within))


def of_other_numbers(case: Case) -> Emulator:
    case.solve(np.array([[10, 12]], dtype=np.int32))
    case.solve(np.array([10.0, 12.0], dtype=np.float32))
    case.train("regresion")  # type: ignore[arg-type]
    return case.train("taylor", design="sobol")


def middle(patient: Case, parameter: str) -> float:
    posterior: Posterior = patient.calibrate(seed=3)
    return float(np.median(posterior[parameter]))


def first_look(patient: Case) -> bool:
    check: Check = patient.check_calibration(budget=60.0)
    mesh: MeshCheck = patient.check_mesh()
    patient.calibrate(folder="out", resume=True, budget=3600)
    path: Solutions = patient.solve(along={"p": (0, "8 mmHg")}, frames=4)
    path = patient.solve(along="p=0..8mmHg")
    return check.verdict == "calibrates" and mesh.loss < 0.1 and not path.failures


def main() -> None:
    try:
        case = Case.read("bar.toml")
    except CaseError as error:
        print(error)
        return
    emulator = case.train("regression", samples=25, progress=False)
    prediction = emulator.predict([10.0, 12.0])
    estimate = emulator.estimate(prediction)
    print(emulator.page("beam.html")["shown error"])
    print(largest(case, 10.0), within(emulator, 10), f"{float(estimate.mean):.1e}", prediction.volumes)


if __name__ == "__main__":
    main()
