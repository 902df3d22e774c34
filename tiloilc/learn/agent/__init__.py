"""What learns, on continuous tasks and on tables, and what it is shown."""
