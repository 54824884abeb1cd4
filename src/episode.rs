//! One episode: the tick loop. The only place where planners and the world meet.
