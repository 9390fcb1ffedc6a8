"""Why a request cannot be met, as the protocol names it."""


class Refusal(Exception):
    """`kind`: "refused" where the request is at fault, "solver" where the simulation is."""

    def __init__(self, kind, message):
        super().__init__(kind, message)
        self.kind = kind

    def __str__(self):
        return self.args[1]
