//! Write-once files and the manifest that names them.
