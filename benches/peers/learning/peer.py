"""What the scripts of all packages share: requests and answers, processor time, data.

A script names its tasks and then waits. Each line that comes in is `TASK SIZE ROUND`; each line that goes out is one JSON
object. The measuring program asks one package after the other, so that the times of a round stand minutes apart at most.
"""

import json
import os
import sys
import time

import numpy as np

# Whatever else a package prints goes where its warnings go.
ANSWERS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

# A short run is repeated until this much processor time has gone by, s.
ENOUGH_S = 0.3
# The start of every search, and its bounds: signal variance, seven length-scales, noise variance.
START = np.log([1.0] + [1.0] * 7 + [0.1])
BOUNDS = np.log([(1e-3, 1e3)] + [(1e-2, 1e3)] * 7 + [(1e-6, 1e1)])


def answer(content):
    print(json.dumps(content), file=ANSWERS, flush=True)


def serve(tasks, versions):
    """Answers requests until there are no more."""
    answer({"tasks": list(tasks), "versions": versions})
    for line in sys.stdin:
        task, size, number = line.split()
        try:
            answer(tasks[task](int(size), int(number)))
        except Exception as error:  # a failure is a result
            answer({"failed": f"{type(error).__name__}: {error}"})


def timed(call):
    """What `call` gives, and the processor time of one call, all threads together."""
    calls, begin = 0, time.process_time()
    while True:
        result = call()
        calls += 1
        spent = time.process_time() - begin
        if spent >= ENOUGH_S:
            return result, spent / calls


def table(name):
    """A file of numbers without a header."""
    return np.loadtxt(os.path.join(sys.argv[1], name + ".csv"), delimiter=",", ndmin=2)


class Process:
    """The tasks of a package for Gaussian processes. `fit(inputs, output)` gives a model, its log marginal likelihood and the
    evaluations; `predict(models, queries)` gives means and variances of the noise-free function, a column an output."""

    def __init__(self, fit, predict):
        self.fit, self.predict, self.data, self.models = fit, predict, {}, {}

    def tasks(self):
        self.run_fit(100, 0)  # what a package does once is not timed
        return {"fit": self.run_fit, "predict_one": self.run_one, "predict_many": self.run_many}

    def load(self, size):
        if size not in self.data:
            names = ("inputs", "outputs", "queries", "truth")
            self.data[size] = [table(f"gp_{size}_{name}") for name in names]
        return self.data[size]

    def run_fit(self, size, _):
        inputs, outputs, queries, truth = self.load(size)
        columns = [np.ascontiguousarray(column) for column in outputs.T]
        found, cpu_s = timed(lambda: [self.fit(inputs, y) for y in columns])
        self.models[size], likelihoods, evaluations = zip(*found)
        mean, _ = self.predict(self.models[size], queries)
        scale = table(f"gp_{size}_scale")[0]
        return {
            "cpu_s": cpu_s,
            "likelihood": float(sum(likelihoods)),
            "evaluations": sum(evaluations),
            "error_m": float(np.sqrt((((mean - truth) * scale) ** 2).mean())),
        }

    def run_one(self, size, _):
        one = self.load(size)[2][17:18]
        return {"cpu_s": timed(lambda: self.predict(self.models[size], one))[1]}

    def run_many(self, size, _):
        queries = self.load(size)[2]
        return {"cpu_s": timed(lambda: self.predict(self.models[size], queries))[1]}
