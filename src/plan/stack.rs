//! The stack: global planner × path stages × fusion × local planner.
