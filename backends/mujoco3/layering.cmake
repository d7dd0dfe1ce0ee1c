# What the layering tests refuse outside this folder, beside what they do for the library of MuJoCo 2: the
# engine is a package of npm, without headers and libraries of its own.
set(engine_headers "mujoco/[a-z]+\\.h")
set(engine_types "(MjModel|MjData|MjSpec)[^A-Za-z_]")
set(engine_words "@mujoco/mujoco")
set(engine_folders "include/mujoco")
set(engine_libraries "libmujoco")
set(engine_probes)
