"""The README's program, the notebooks, and annotations."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

HERE = Path(__file__).parent
NOTEBOOKS = sorted((HERE.parent / "examples").glob("*.ipynb"))


def run(program: str, folder: Path) -> str:
    (folder / "program.py").write_text(program)
    start = time.monotonic()
    found = subprocess.run(
        [sys.executable, "-W", "ignore", "program.py"], cwd=folder, capture_output=True, text=True, env={**os.environ, "MPLBACKEND": "Agg"}
    )
    assert found.returncode == 0, found.stderr
    print(f"{time.monotonic() - start:.1f} s\n{found.stdout}")
    return found.stdout


def test_the_readme_leads_to_an_emulator_with_its_error(tmp_path: Path) -> None:
    text = (HERE.parent / "README.md").read_text()
    [program] = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    lines = [line for line in program.splitlines() if line.strip() and not line.startswith(("#", "import", "from"))]
    assert len(lines) <= 15
    said = run(program, tmp_path)
    estimates = [float(number) for number in re.findall(r"estimated error (\S+) mm", said)]
    assert len(estimates) == 2 and estimates[1] < 0.1 * estimates[0]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(notebook: Path, tmp_path: Path) -> None:
    for package in ("meshio", "ipykernel"):
        pytest.importorskip(package)
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    cells = nbformat.read(notebook, as_version=4)
    nbformat.validate(cells)
    assert all(not cell.get("outputs") for cell in cells.cells), "results are made by running, not stored"
    start = time.monotonic()
    nbclient.NotebookClient(cells, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    print(f"{notebook.stem}: {time.monotonic() - start:.1f} s")
    for cell in cells.cells:
        for output in cell.get("outputs", []):
            print(output.get("text", output.get("data", {}).get("text/plain", "")), end="")


def test_annotations_hold_for_a_client(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    found = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(HERE / "client.py")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert found.returncode == 0, found.stdout
