# Sets MESHLAB_SOURCE_DIR, MESHLAB_VERSION and SPHEROSEG_MESHLAB_COMMON, or stops.

if(NOT SPHEROSEG_SCALAR MATCHES "^(double|float)$")
    message(FATAL_ERROR "SPHEROSEG_SCALAR must be double or float, found '${SPHEROSEG_SCALAR}'.")
endif()

if(NOT MESHLAB_SOURCE_DIR AND DEFINED ENV{MESHLAB_SOURCE_DIR})
    set(MESHLAB_SOURCE_DIR "$ENV{MESHLAB_SOURCE_DIR}")
endif()
if(NOT MESHLAB_SOURCE_DIR)
    set(MESHLAB_SOURCE_DIR ${CMAKE_SOURCE_DIR}/.cache/meshlab-2025.07)
endif()
if(NOT EXISTS ${MESHLAB_SOURCE_DIR}/src/common/plugins/interfaces/filter_plugin.h
        OR NOT EXISTS ${MESHLAB_SOURCE_DIR}/src/vcglib/vcg/complex/complex.h)
    message(FATAL_ERROR "No MeshLab headers in '${MESHLAB_SOURCE_DIR}': set MESHLAB_SOURCE_DIR to "
        "MeshLab's sources with vcglib (or run scripts/fetch_meshlab_headers.sh).")
endif()
file(STRINGS ${MESHLAB_SOURCE_DIR}/ML_VERSION MESHLAB_VERSION LIMIT_COUNT 1)
if(SPHEROSEG_SCALAR STREQUAL "double")
    string(APPEND MESHLAB_VERSION "d")
endif()

if(NOT SPHEROSEG_MESHLAB_COMMON AND SPHEROSEG_SCALAR STREQUAL "double")
    if(NOT Python_EXECUTABLE AND EXISTS ${CMAKE_SOURCE_DIR}/.venv/bin/python)
        set(Python_EXECUTABLE ${CMAKE_SOURCE_DIR}/.venv/bin/python)
    endif()
    find_package(Python REQUIRED COMPONENTS Interpreter)
    # Without importing PyMeshLab, which would need its shared libraries' own dependencies.
    execute_process(
        COMMAND ${Python_EXECUTABLE} -c "import importlib.util as u; \
print(u.find_spec('pymeshlab').submodule_search_locations[0], end='')"
        OUTPUT_VARIABLE pymeshlab_dir
        RESULT_VARIABLE pymeshlab_missing
        ERROR_QUIET)
    if(pymeshlab_missing OR NOT EXISTS ${pymeshlab_dir}/lib/libmeshlab-common.so)
        message(FATAL_ERROR "${Python_EXECUTABLE} has no PyMeshLab: install it there, or set "
            "SPHEROSEG_MESHLAB_COMMON to the libmeshlab-common.so of the host.")
    endif()
    set(SPHEROSEG_MESHLAB_COMMON ${pymeshlab_dir}/lib/libmeshlab-common.so)
endif()
message(STATUS "MeshLab ${MESHLAB_VERSION}, host library: ${SPHEROSEG_MESHLAB_COMMON}")
