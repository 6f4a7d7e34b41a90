//! The zonal equations: one operator, one solver, reports.
