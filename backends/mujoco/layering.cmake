# What the layering tests refuse outside this folder: regular expressions, and headers to try.
set(engine_headers "mujoco/[a-z]+\\.h")
set(engine_types "mj(Model|Data|VFS|Contact|Option|tNum)[^A-Za-z_]")
set(engine_words "libmujoco|mj_[a-z]+")
set(engine_folders "include/mujoco")
set(engine_libraries "libmujoco")
# Its headers lie on the compiler's own path: nothing can keep them out of reach, only the search for names.
set(engine_probes)
