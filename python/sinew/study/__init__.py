"""Studies: a function of parameters, evaluated for many designs or specimens, with results that survive a kill.

`Study.run` writes every trial to a journal as it is proposed and as it ends. A study opened again continues where it was:
ended trials are not run again, a trial that was cut off runs again with its parameters and seed.
"""

from ._journal import Trial
from ._report import pareto_front, write_report
from ._robustness import robustness
from ._routing import routing
from ._study import Range, Study

__all__ = ["Range", "Study", "Trial", "pareto_front", "robustness", "routing", "write_report"]
