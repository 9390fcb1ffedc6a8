"""PyTorch: `nn.RNN` of 30 units and a linear output, single precision, Adam, windows of 10, errors of every row."""

import torch
from peer import serve, table, timed
from torch import nn

torch.set_num_threads(1)
# As ours: units, rows of a window, windows of a batch, learning rate, share of the rows that are trained on.
HIDDEN, WINDOW, BATCH, RATE, TRAINED = 30, 10, 64, 4e-3, 0.7
# The held-out rows are looked at in so many runs side by side: one run would take torch 3,000 steps, one after the other.
RUNS = 30
MOST_EPOCHS = 1000

INPUTS, OUTPUTS = (torch.as_tensor(table(f"elman_{name}"), dtype=torch.float32) for name in ("inputs", "outputs"))
SCALE_M = torch.as_tensor(table("elman_scale")[0], dtype=torch.float32)
COUNT = round(TRAINED * len(INPUTS))
LENGTH = (len(INPUTS) - COUNT) // RUNS
HELD_OUT = slice(COUNT, COUNT + RUNS * LENGTH)
# A copy with every window side by side, made once: rows overlap.
WINDOWS = [
    rows[:COUNT].unfold(0, WINDOW, 1).transpose(1, 2).contiguous() for rows in (INPUTS, OUTPUTS)
]
HELD_OUT_RUNS = [rows[HELD_OUT].reshape(RUNS, LENGTH, -1) for rows in (INPUTS, OUTPUTS)]


class Elman(nn.Module):
    def __init__(self):
        super().__init__()
        self.state = nn.RNN(INPUTS.shape[1], HIDDEN, batch_first=True)
        self.output = nn.Linear(HIDDEN, OUTPUTS.shape[1])

    def forward(self, inputs):
        return self.output(self.state(inputs)[0])


def train(seed, until):
    """Trains until `until(epochs, error)` holds; gives the epochs and the last mean absolute error on the held-out rows, metres."""
    torch.manual_seed(seed)
    network = Elman()
    adam = torch.optim.Adam(network.parameters(), lr=RATE)
    for epoch in range(1, MOST_EPOCHS + 1):
        for some in torch.randperm(len(WINDOWS[0])).split(BATCH):
            adam.zero_grad(set_to_none=True)
            nn.functional.mse_loss(network(WINDOWS[0][some]), WINDOWS[1][some]).backward()
            adam.step()
        with torch.no_grad():
            error_m = float(((network(HELD_OUT_RUNS[0]) - HELD_OUT_RUNS[1]).abs() * SCALE_M).mean())
        if until(epoch, error_m):
            break
    return epoch, error_m


def epoch(_, number):
    count = 4
    (_, error_m), cpu_s = timed(lambda: train(number, lambda done, _: done == count))
    return {"cpu_s": cpu_s / count, "error_m": error_m}


def until_error(_, number):
    target_m = float(table("elman_target")[0, 0])
    (count, error_m), cpu_s = timed(lambda: train(number, lambda _, error_m: error_m <= target_m))
    content = {"cpu_s": cpu_s, "evaluations": count, "error_m": error_m}
    return content if error_m <= target_m else {"failed": f"still {1e3 * error_m:.3f} mm after {count} epochs"}


def product(kind):
    def run(size, _):
        left = torch.randn(size, size, dtype=kind)
        out = torch.empty_like(left)
        return {"cpu_s": timed(lambda: torch.mm(left, left, out=out))[1]}

    return run


train(0, lambda done, _: True)  # what torch does once is not timed
serve(
    {
        "epoch": epoch,
        "until_error": until_error,
        "product_f64": product(torch.float64),
        "product_f32": product(torch.float32),
    },
    {"PyTorch": torch.__version__},
)
