//! Traversal on the CPU: closest and any hit over one or two levels, and the brute force it is judged by.
