"""tiloilc: compile a YAML task file with a temporal-logic formula into a trained agent."""

__version__ = "0.1.0"
