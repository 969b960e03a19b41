# Finds the host that the plugin is built for, or stops; defines the target meshlab_host.

set(SPHEROSEG_SCALAR double CACHE STRING
    "Scalar type of the host: double for PyMeshLab, float for the MeshLab application")
set_property(CACHE SPHEROSEG_SCALAR PROPERTY STRINGS double float)
set(MESHLAB_SOURCE_DIR "" CACHE PATH "MeshLab's sources with the vcglib submodule")
set(SPHEROSEG_MESHLAB_RELEASE "" CACHE STRING
    "Release of the host, if its interface is that of the sources but its number is another")
set(SPHEROSEG_MESHLAB_COMMON "" CACHE FILEPATH
    "libmeshlab-common.so of the host; found in PyMeshLab's wheel when the scalar type is double")

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
if(SPHEROSEG_MESHLAB_RELEASE)
    set(MESHLAB_VERSION ${SPHEROSEG_MESHLAB_RELEASE})
else()
    file(STRINGS ${MESHLAB_SOURCE_DIR}/ML_VERSION MESHLAB_VERSION LIMIT_COUNT 1)
endif()
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

find_package(Qt5 REQUIRED COMPONENTS Core Gui Widgets Xml OpenGL)
find_package(Eigen3 REQUIRED NO_MODULE)
find_path(GLEW_INCLUDE_DIR GL/glew.h REQUIRED)

# Defines target `name`: what every source that sees MeshLab's headers is compiled with. `library`
# may be empty: the host has it loaded.
function(add_meshlab_host name version scalar library)
    add_library(${name} INTERFACE)
    target_compile_features(${name} INTERFACE cxx_std_17)
    target_compile_definitions(${name} INTERFACE
        MESHLAB_VERSION=${version}
        MESHLAB_SCALAR=${scalar}
        QT_PLUGIN)
    target_include_directories(${name} SYSTEM INTERFACE
        ${MESHLAB_SOURCE_DIR}/src
        ${MESHLAB_SOURCE_DIR}/src/common
        ${MESHLAB_SOURCE_DIR}/src/vcglib
        ${GLEW_INCLUDE_DIR})
    target_link_libraries(${name} INTERFACE
        Eigen3::Eigen Qt5::Core Qt5::Gui Qt5::Widgets Qt5::Xml Qt5::OpenGL ${library})
endfunction()

add_meshlab_host(meshlab_host ${MESHLAB_VERSION} ${SPHEROSEG_SCALAR} "${SPHEROSEG_MESHLAB_COMMON}")
