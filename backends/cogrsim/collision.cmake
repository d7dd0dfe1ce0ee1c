# Contact points of all shapes, as a library: for CogRSim's own dynamics, and for engines that have no
# contact of their own. Bullet's double-precision collision detection serves for the distance queries
# that have no closed form.
if(TARGET cogrsim_collision)
  return()
endif()
find_path(COGRSIM_BULLET_INCLUDE btBulletCollisionCommon.h PATH_SUFFIXES bullet REQUIRED)
find_library(COGRSIM_BULLET_COLLISION BulletCollision-float64 REQUIRED)
find_library(COGRSIM_BULLET_MATH LinearMath-float64 REQUIRED)

set(source ${CMAKE_CURRENT_LIST_DIR}/src)
add_library(cogrsim_collision STATIC
  ${source}/collision/colliders.cpp
  ${source}/collision/compliant_contact.cpp
  ${source}/collision/concave.cpp
  ${source}/collision/contact_rates.cpp
  ${source}/collision/detector.cpp
  ${source}/collision/gjk.cpp
  ${source}/collision/primitives.cpp)
target_compile_features(cogrsim_collision PUBLIC cxx_std_17)
set_target_properties(cogrsim_collision PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
target_include_directories(cogrsim_collision PUBLIC ${source})
target_include_directories(cogrsim_collision SYSTEM PUBLIC ${COGRSIM_BULLET_INCLUDE})
target_compile_definitions(cogrsim_collision PUBLIC BT_USE_DOUBLE_PRECISION)
# Its inner loops are short and of known length: -O2 leaves them loops, -O3 writes them out.
target_compile_options(cogrsim_collision PRIVATE -UNDEBUG $<$<CONFIG:RelWithDebInfo>:-O2>
  $<$<CONFIG:Release>:-O3>)
target_link_libraries(cogrsim_collision PUBLIC cogrsim::sdk ${COGRSIM_BULLET_COLLISION}
  ${COGRSIM_BULLET_MATH} PRIVATE cogrsim_warnings)
