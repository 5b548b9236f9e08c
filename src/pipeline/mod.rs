//! From a pipeline file to a finished run: raw, check, plan, resume, exec.
