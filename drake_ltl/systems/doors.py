"""LeafSystem that tells which regions are closed, as contacts at their doors do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem, OutputPort


class Doors(LeafSystem):
    """A contact at each region.

    .. pydrake_system::

        name: Doors
        output_ports:
        - closed

    `closed` (K,) is 1 for regions that nobody may enter, 0 for others, in the scenario's order. It is a parameter, 0
    at first.
    """

    def __init__(self, regions: Sequence[str]):
        super().__init__()
        self.set_name("doors")
        self._names = list(regions)
        self._closed = self.DeclareNumericParameter(BasicVector(np.zeros(len(self._names))))
        self._output = self.DeclareVectorOutputPort("closed", len(self._names), self._calc_closed)

    def get_closed_output_port(self) -> OutputPort:
        return self._output

    def Close(self, context: Context, region: str) -> None:
        """From now on nobody may enter."""
        context.get_mutable_numeric_parameter(self._closed).SetAtIndex(self._names.index(region), 1.0)

    def _calc_closed(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_numeric_parameter(self._closed).value())
