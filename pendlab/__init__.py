"""pendlab: balancing and attitude control of double and triple inverted pendulums.

The package carries one control paper (Medrano-Cerda, Eldukhri and Cetin, 1995) from the Lagrangian
to the rig on the bench. The table below is its contents in the order in which the data flow; each
name is imported from its module when first used.
"""

from importlib import import_module

__version__ = "2.0.0"

_CONTENTS = {
    "parameters": ("Link", "Motor", "Filters", "Pendulum", "load", "rigs"),
    "lagrange": ("EquationsOfMotion", "derive"),
    "models": ("linearize", "nonlinear", "energy", "with_filters"),
    "sampled": ("sample", "align", "alignment_interval", "add_integrator"),
    "studies.controllability": (
        "controllability_ratio",
        "distance_to_uncontrollability",
        "in_units",
        "with_bar",
        "least_effort",
        "recoverable_tilt",
        "controllability_measures",
    ),
    "gain": ("lqr",),
    "observers": ("Observer", "ObserverFamily", "observer", "observer_family", "luenberger"),
    "controllers": ("Controller", "ControllerState", "controller"),
    "loop": (
        "frequency_response",
        "frequency_grid",
        "open_loop",
        "broken_at",
        "state_feedback_loop",
        "closed_loop_eigenvalues",
        "loop_gain",
        "return_differences",
        "time_constant",
        "margins",
    ),
    "nyquist": ("encirclements",),
    "studies.structured": ("StructuredMargin", "structured_margin"),
    "design": ("Design",),
    "studies.transmission": ("with_torques", "closed_loop", "rms", "peak_gain"),
    "paper.ledger": ("published",),
    "paper.designs": ("paper_design",),
    "paper.scoreboard": ("scoreboard",),
    "bench.imperfections": ("Imperfections", "Pulse", "bench_imperfections", "bench_start"),
    "bench.simulation": ("Run", "simulate"),
    "bench.many": ("Runs", "simulate_many"),
    "studies.code_export": ("to_c",),
    "paper.experiment": ("bench_run", "signals", "fill"),
    "studies.timing": ("step_times",),
    "studies.pushes": ("largest_pulses", "force_levers"),
    "figures": ("figure", "show", "save"),
    "figures.style": ("new_figure", "styled", "look", "describe", "COLORS"),
    "figures.curves": ("lines",),
    "figures.moving": ("animation",),
    "figures.traces": ("compare", "draw_traces", "pushes_figure"),
    "figures.rootlocus": ("root_locus",),
    "figures.disturbances": ("transmission_figure", "gain_region_figure"),
    "figures.bar": ("bar_study", "bars"),
    "figures.illustrations": ("biped", "strobe", "modes", "block_chains"),
    "figures.seriesmap": ("series_map",),
    "figures.tables": ("parameter_table", "bench_table", "bench_notes"),
    "classroom.checks": ("check", "Verdict"),
    "classroom.gaps": ("skip_unanswered",),
    "classroom.own_rig": ("my_rig",),
    "classroom.contest": ("contest", "Score", "write_leaderboard"),
    "classroom.doctor": ("doctor",),
    "widgets.parts": ("Slider", "Switch", "Choice", "View"),
    "widgets.panel": ("Panel",),
    "widgets.bench_panels": ("bench_panel",),
    "widgets.live": ("LiveRig", "live_rig"),
    "widgets.design_panels": ("kp_panel", "observer_panel", "triple_panel", "weights_panel"),
    "widgets.model_panels": ("bar_panel", "sampling_panel"),
}
_HOME = {name: module for module, names in _CONTENTS.items() for name in names}

__all__ = ["__version__", *_HOME]


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module 'pendlab' has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(set(globals()) | set(__all__))
