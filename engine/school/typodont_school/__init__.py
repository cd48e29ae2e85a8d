"""A school's service: benches hand in recorded sessions, people see results."""
