"""What the scripts of all environments share: requests and answers, processor time.

A script stays up over all rounds. Each line that comes in is a JSON object with the name of a task; each line that goes out is
the answer.
"""

import json
import os
import sys
import time
from importlib.metadata import version

# Whatever else a package prints goes where its warnings go.
ANSWERS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)


def answer(content):
    print(json.dumps(content), file=ANSWERS, flush=True)


def serve(tasks, packages):
    """Answers requests until there are no more."""
    answer({"versions": {name: version(name) for name in packages}})
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer(tasks[request.pop("task")](**request))
        except Exception as error:  # a failure is a result
            answer({"failed": f"{type(error).__name__}: {error}"})


def timed(call):
    """What `call` gives, and its times: that of the processor, all threads together, and that of the wall clock."""
    began, cpu = time.perf_counter(), time.process_time()
    result = call()
    return result, {"cpu_s": time.process_time() - cpu, "wall_s": time.perf_counter() - began}


def case(name):
    """A robot as `cargo bench --bench peers -- cases` describes it."""
    with open(os.path.join(sys.argv[1], f"{name}.json")) as file:
        return json.load(file)
