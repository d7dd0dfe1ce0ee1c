# What the layering tests refuse outside this folder: regular expressions, and headers to try.
set(engine_headers "bt[A-Z]|[Bb]ullet[^/\"]*[/.]|LinearMath/")
set(engine_types "bt(Vector3|Quaternion|Transform|Scalar|RigidBody|MultiBody|Collision|Discrete)")
set(engine_words "[Bb]ullet|BULLET")
set(engine_folders "bullet|Bullet")
set(engine_libraries "Bullet|LinearMath")
set(engine_probes btBulletDynamicsCommon.h btBulletCollisionCommon.h LinearMath/btVector3.h
  BulletDynamics/Featherstone/btMultiBody.h)
