//! Observations out of core: the segment format, its writer, its reader, and the merge of many segments.
