# cogrsim_component(VARIABLE): the Debian package of what the current source folder installs.
# A folder in backends/ or renderers/ is a package of its own, but for our own dynamics: an installation
# has at least one engine.
function(cogrsim_component variable)
  set(component cogrsim)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  if(folder MATCHES "^(backend|renderer)s/(.*)" AND NOT CMAKE_MATCH_2 STREQUAL "cogrsim")
    set(component cogrsim-${CMAKE_MATCH_1}-${CMAKE_MATCH_2})
    set_property(GLOBAL APPEND PROPERTY COGRSIM_PARTS_OF_THEIR_OWN ${component})
  endif()
  set(${variable} ${component} PARENT_SCOPE)
endfunction()
