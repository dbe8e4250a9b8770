"""LeafSystem that measures the plant's state with noise, and late."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    InputPort,
    LeafSystem,
    OutputPort,
)

from drake_ltl.systems.state_places import StatePlaces


class Sensors(LeafSystem):
    """What controllers, supervisor and monitors see of the plant.

    .. pydrake_system::

        name: Sensors
        input_ports:
        - state
        output_ports:
        - state
        - age

    `state` is the plant's whole state (positions and velocities of everything). What comes out is as old as the delay,
    a whole number of samples, with white noise on all numbers. The noise of a sample depends on the seed and on the
    time alone. `age` (1,) is how old it is [s], as stamps of samples say.
    """

    def __init__(
        self,
        places: StatePlaces,
        num_positions: int,
        period: float,
        *,
        position_noise: float = 0.0,
        velocity_noise: float = 0.0,
        delay: float = 0.0,
        seed: int = 0,
    ):
        """
        Args:
            places: says what is where in `state`.
            num_positions: how many numbers of `state` are positions; they come first.
            period: of samples [s].
            position_noise, velocity_noise: standard deviations [m, rad; m/s, rad/s].
            delay: [s]
            seed: of the noise.
        """
        super().__init__()
        self.set_name("sensors")
        self._period, self._seed, self._late = period, seed, round(delay / period)
        self._sigma = np.repeat([position_noise, velocity_noise], [num_positions, places.size - num_positions])
        self._latest: tuple[int, np.ndarray] = (-1, np.zeros(places.size))
        self._state = self.DeclareVectorInputPort("state", places.size)
        self._history = [self.DeclareDiscreteState(places.size) for _ in range(self._late)]
        """The sample before this one, the one before that .."""
        self._begun = self.DeclareDiscreteState(1)
        """Whether there is a history: while others initialize there is none."""
        if self._late:
            self.DeclareInitializationDiscreteUpdateEvent(self._begin)
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._remember)
        self._measured = self.DeclareVectorOutputPort("state", places.size, self._calc_state)
        self._age = self.DeclareVectorOutputPort("age", 1, self._calc_age, {self.nothing_ticket()})

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_state_output_port(self) -> OutputPort:
        return self._measured

    def get_age_output_port(self) -> OutputPort:
        return self._age

    def _calc_age(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([self._late * self._period])

    def _calc_state(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._measure(context))

    def _measure(self, context: Context) -> np.ndarray:
        late = self._late and context.get_discrete_state(self._begun).value()[0]
        seen = context.get_discrete_state(self._history[-1]).value() if late else self._state.Eval(context)
        return seen + self._noise(round(context.get_time() / self._period))

    def _noise(self, sample: int) -> np.ndarray:
        """A pure function of the sample's number, the latest one kept."""
        if self._latest[0] != sample:
            drawn = np.random.default_rng((self._seed, sample)).standard_normal(len(self._sigma))
            self._latest = (sample, self._sigma * drawn)
        return self._latest[1]

    def _begin(self, context: Context, values: DiscreteValues) -> EventStatus:
        """Nothing has moved before."""
        for index in self._history:
            values.set_value(index, self._state.Eval(context))
        values.set_value(self._begun, np.ones(1))
        return EventStatus.Succeeded()

    def _remember(self, context: Context, values: DiscreteValues) -> EventStatus:
        before = [self._state.Eval(context), *(context.get_discrete_state(i).value() for i in self._history)]
        for index, value in zip(self._history, before, strict=False):
            values.set_value(index, value)
        return EventStatus.Succeeded()
