//! Memory that was freed goes back to the operating system.
//!
//! The allocator of GNU systems keeps more than is good for a program of few large steps: what is freed at the end of a heap it keeps up to twice the largest
//! block that was ever freed, for each thread, and what lies between blocks that live on it always keeps. Elsewhere nothing is done.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod gnu {
    use std::ffi::c_int;

    #[allow(unsafe_code)]
    unsafe extern "C" {
        pub fn mallopt(parameter: c_int, value: c_int) -> c_int;
        pub fn malloc_trim(pad: usize) -> c_int;
    }

    pub const M_TRIM_THRESHOLD: c_int = -1;
}

/// Keep at most a MiB at the end of each heap, from now on.
pub fn keep_little() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: glibc's function with its types and a parameter that it knows. It is called once, before any thread is started, and nothing here depends on what it
    // answers.
    #[allow(unsafe_code)]
    unsafe {
        gnu::mallopt(gnu::M_TRIM_THRESHOLD, 1 << 20);
    }
}

/// Give back what was freed between blocks that live on.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: glibc's function with its types. It may be called at any time and from any thread, touches free memory alone, and nothing here depends on what it
    // answers.
    #[allow(unsafe_code)]
    unsafe {
        gnu::malloc_trim(0);
    }
}
