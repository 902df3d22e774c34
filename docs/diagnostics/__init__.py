"""One page a diagnostic code, data of the package: `tiloilc explain CODE` prints it."""
