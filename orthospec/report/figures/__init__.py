"""The figures of a report: from arrays to panels, one module a subject."""
