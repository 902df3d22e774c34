"""YAML text to a typed, frozen task with the place of every node."""
