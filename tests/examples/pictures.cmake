# check_pictures(NAME…): each NAME.png in FOLDER is a picture. `said`: what the experiment printed.
function(check_pictures)
  foreach(name ${ARGN})
    if(NOT EXISTS ${FOLDER}/${name}.png)
      message(FATAL_ERROR "${name}.png is missing:\n${said}")
    endif()
    file(READ ${FOLDER}/${name}.png head LIMIT 8 HEX)
    file(SIZE ${FOLDER}/${name}.png size)
    # A PNG's signature; an empty picture of this size is smaller.
    if(NOT head STREQUAL "89504e470d0a1a0a" OR size LESS 1000)
      message(FATAL_ERROR "${name}.png is no picture (${size} bytes)")
    endif()
  endforeach()
endfunction()
