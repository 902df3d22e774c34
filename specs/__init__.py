"""The paper's task files: one YAML a task, data of the package."""
