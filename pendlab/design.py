"""The whole way from a rig and its weights to a controller, as one value that can be changed."""

from dataclasses import dataclass, fields, replace
from functools import cached_property

from ._arguments import array, flag, instance, number, whole
from .controllers import controller
from .gain import lqr
from .loop import broken_at, open_loop, state_feedback_loop
from .models import linearize, with_filters
from .observers import observer_family
from .parameters import Pendulum
from .sampled import add_integrator, align, sample


@dataclass(frozen=True)
class Design:
    """A rig with the choices of section 4; everything else follows and is computed when asked for.

    Parameters
    ----------
    rig : Pendulum
    Q, R : weights of the augmented state and of the inputs that F drives (`lqr`)
    E : observer dynamics (`observer_family`)
    kp : k_p of motor 2's position loop, or None where F drives every motor
    coefficients : of the observer in its family's canonical basis; None takes the quietest member
    dt : sampling time, s
    tracked : index of the output with an integrator, or a tuple of them

    ``design.changed(kp=5.0)`` is the design with one choice changed, as `dataclasses.replace` gives
    it, and keeps what does not depend on the change.

    >>> pl.Design(pl.load("double"), Q=(0.1, 100, 0, 0.01, 1), R=3, E=0.9).F.round(2)  # (23)
    array([[-254.6 ,  -99.18,  -51.35,  -29.85,    0.55]])
    """

    rig: Pendulum
    Q: tuple
    R: tuple
    E: tuple
    kp: float | None = None
    coefficients: tuple | None = None
    dt: float = 0.01
    tracked: int | tuple = 1

    def __post_init__(self):
        instance("rig", self.rig, Pendulum, 'pl.load("double")')
        for name in ("Q", "R", "E"):
            array(name, getattr(self, name))
        if self.kp is not None:
            number("kp", self.kp)
        if self.coefficients is not None:
            array("coefficients", self.coefficients)
        number("dt", self.dt, above=0)
        for index in self.tracked if isinstance(self.tracked, (tuple, list)) else [self.tracked]:
            whole("tracked", index)

    def changed(self, **choices):
        """The design with other choices; computed values that do not depend on them go along."""
        known = [field.name for field in fields(self)]
        if unknown := choices.keys() - set(known):
            raise TypeError(f"{min(unknown)}: no choice of a design; these are {', '.join(known)}.")
        new = replace(self, **choices)
        for name, needs in NEEDS.items():
            if name in self.__dict__ and not needs & choices.keys():
                new.__dict__[name] = self.__dict__[name]
        return new

    @cached_property
    def plant(self):
        """Continuous linear model, (1) or (2)."""
        return linearize(self.rig)

    @cached_property
    def model(self):
        """Sampled model without filters, (13) or (14)."""
        return sample(self.plant, self.dt)

    @cached_property
    def filtered(self):
        """Sampled model with the filters of Table 5."""
        return sample(with_filters(self.plant, self.rig.filters), self.dt)

    @cached_property
    def augmented(self):
        """What F is designed for: the (aligned) model with its integrator, (15) and (19)."""
        model = self.model if self.kp is None else align(self.model, self.kp)
        return add_integrator(model, self.tracked)

    @cached_property
    def F(self):
        """Optimal gain of the augmented model, (23) or (32)."""
        return lqr(self.augmented, self.Q, self.R)

    @cached_property
    def family(self):
        """All observers with dynamics E and H = 0, section 3."""
        return observer_family(self.model, self.E)

    @cached_property
    def observer(self):
        """The chosen member of the family."""
        if self.coefficients is None:
            return self.family.best()
        return self.family.member(self.coefficients)

    @cached_property
    def controller(self):
        """(29) with (30) or (38), limited to the rig's voltages."""
        u_max = self.rig.u_max
        return controller(self.F, self.observer, self.dt, self.tracked, self.kp, u_max=u_max)

    @cached_property
    def nominal_loop(self):
        """P G at the plant inputs, without filters."""
        return open_loop(self.controller, self.model)

    @cached_property
    def filtered_loop(self):
        """P G_f at the plant inputs, with filters."""
        return open_loop(self.controller, self.filtered)

    @cached_property
    def state_feedback_loop(self):
        """F (zI - A)^-1 B at the inputs that F drives."""
        return state_feedback_loop(self.augmented, self.F)

    def loop(self, index=0, filters=False):
        """The loop broken at one input with all the others closed."""
        whole("index", index, most=self.rig.n_motors - 1)
        loop = self.filtered_loop if flag("filters", filters) else self.nominal_loop
        return loop if loop.ninputs == 1 else broken_at(loop, index)


# Computed value -> the choices that it follows from, for `Design.changed`.
NEEDS = {
    "plant": {"rig"},
    "model": {"rig", "dt"},
    "filtered": {"rig", "dt"},
    "augmented": {"rig", "dt", "kp", "tracked"},
    "F": {"rig", "dt", "kp", "tracked", "Q", "R"},
    "family": {"rig", "dt", "E"},
    "observer": {"rig", "dt", "E", "coefficients"},
}
