// The page while `sinew serve` gives it: where the sliders rest the solver corrects the body, and the true error stands beside the shown one.
"use strict";
for (const view of sinewViewer.views) {
  const [{ state, root, digits }, { emulator: { parameters }, length }] = [view, view.data];
  const norms = (u) => Array.from({ length: u.length / 3 }, (_, n) => Math.hypot(u[3 * n], u[3 * n + 1], u[3 * n + 2]));
  const mean = (values) => values.reduce((sum, x) => sum + x, 0) / values.length;
  let [timer, turn] = [0, 0];
  const correct = async () => {
    const [own, start, shown] = [++turn, performance.now(), Array.from(view.model(state.shares))];
    const input = [parameters.map((p, i) => sinewViewer.valueAt(p, state.shares[i]) / p.size)];
    for (const name of ["corrected", "solver"]) {
      const answer = await fetch("Surface", { method: "POST", body: JSON.stringify({ name, input }) }).catch((error) => error);
      const { displacement, error } = answer.json ? await answer.json() : { error: answer };
      if (own !== turn) return;
      const [apart, last] = [displacement && norms(displacement.map((u, i) => u - shown[i])), name === "solver"];
      const share = displacement && (100 * mean(apart)) / mean(norms(displacement));
      const found = () => `${last ? "true error" : "error by one Newton step"} ${digits(mean(apart), 2)} ${length} in the mean (${digits(share, 2)} %), ` +
        `${digits(Math.max(...apart), 2)} ${length} at most` + (last ? `; solved in ${digits(performance.now() - start, 2)} ms` : "");
      state.solved = { displacement, name, mean: apart && mean(apart), words: error ? `not solved: ${error.message}` : found() };
      view.refresh(true);
    }
  };
  const wait = () => { turn++; clearTimeout(timer); timer = setTimeout(correct, 150); };
  root.addEventListener("moved", wait);
  wait();
}
