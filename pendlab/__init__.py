"""pendlab: balancing and attitude control of double and triple inverted pendulums.

The package carries one control paper (Medrano-Cerda, Eldukhri and Cetin, 1995) from the Lagrangian
to the rig on the bench. The table below is its contents in reading order; each name is imported
from its module when first used. Examples in docstrings begin after ``import pendlab as pl``.
"""

from importlib import import_module

__version__ = "2.0.0"

_CONTENTS = {
    # The rig and its equations (section 2, Appendix A)
    "parameters": "Link Motor Filters Pendulum load rigs",
    "lagrange": "EquationsOfMotion derive",
    "models": "linearize nonlinear energy with_filters",
    # What the controller sees, and its gain (sections 2 to 4)
    "sampled": "sample align add_integrator",
    "gain": "lqr",
    # Observers with H = TB = 0 and the controller (sections 3 to 5)
    "observers": "Observer ObserverFamily observer observer_family luenberger",
    "controllers": "Controller ControllerState controller",
    # Relative stability (section 4); the whole way as one value
    "loop": (
        "frequency_response frequency_grid open_loop broken_at state_feedback_loop "
        "closed_loop_eigenvalues loop_gain return_differences margins"
    ),
    "nyquist": "encirclements",
    "design": "Design",
    # bench: the rig in software (section 5)
    "bench.imperfections": "Imperfections Pulse",
    "bench.gearbox": "bench_imperfections bench_rig bench_start",
    "bench.simulation": "Run simulate",
    "bench.many": "Runs simulate_many",
    # paper: its numbers, designs and runs
    "paper.ledger": "published",
    "paper.designs": "paper_design",
    "paper.alignment": "alignment_interval",
    "paper.scoreboard": "scoreboard",
    "paper.experiment": "bench_ensemble bench_run signals tick_hits tick_intervals",
    "paper.changes": "changed hits_without exponents",
    # studies: built on the core and the bench
    "studies.controllability": (
        "controllability_ratio distance_to_uncontrollability in_units with_bar "
        "least_effort recoverable_tilt controllability_measures"
    ),
    "studies.structured": "StructuredMargin structured_margin",
    "studies.transmission": "with_torques closed_loop time_constant rms peak_gain",
    "studies.code_export": "to_c",
    "studies.timing": "step_times",
    "studies.pushes": "largest_pulses force_levers",
    "studies.describing": "limit_cycles",
    "studies.unknown_input": "unknown_input_observer",
    # figures
    "figures": "figure show save",
    "figures.style": "new_figure styled look describe COLORS",
    "figures.curves": "lines",
    "figures.moving": "animation",
    "figures.traces": "compare draw_traces pushes_figure",
    "figures.rootlocus": "root_locus",
    "figures.disturbances": "transmission_figure gain_region_figure",
    "figures.bar": "bar_study bars",
    "figures.illustrations": "biped strobe modes block_chains",
    "figures.evidence": "before_after ablation what_sets_what pushed cycles_figure",
    "figures.seriesmap": "series_map",
    "figures.tables": "parameter_table bench_table bench_notes",
    # widgets: figures that move
    "widgets.parts": "Slider Switch Choice View",
    "widgets.panel": "Panel",
    "widgets.bench_panels": "bench_panel",
    "widgets.live": "LiveRig live_rig",
    "widgets.design_panels": "kp_panel observer_panel triple_panel weights_panel",
    "widgets.model_panels": "bar_panel sampling_panel",
    # classroom: exercises, own rigs, contests
    "classroom.checks": "check Verdict",
    "classroom.gaps": "skip_unanswered",
    "classroom.own_rig": "my_rig",
    "classroom.contest": "contest Score write_leaderboard",
    "classroom.doctor": "doctor",
}
_HOME = {name: module for module, names in _CONTENTS.items() for name in names.split()}
__all__ = ["__version__", *_HOME]


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module 'pendlab' has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(set(globals()) | set(__all__))
