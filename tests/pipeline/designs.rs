//! Every file in designs/ through the main job.
