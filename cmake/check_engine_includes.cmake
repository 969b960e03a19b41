# Run with -D ENGINE_DIR=... -P: fails when an engine file includes Qt, VCG or MeshLab.
file(GLOB_RECURSE engine_files ${ENGINE_DIR}/*.h ${ENGINE_DIR}/*.cpp)
foreach(engine_file IN LISTS engine_files)
    file(STRINGS ${engine_file} foreign_includes
        REGEX "^[ \t]*#[ \t]*include[ \t]*[<\"](Qt|Q[A-Z]|vcg/|wrap/|common/|GL/|.*meshlab)")
    if(foreign_includes)
        message(FATAL_ERROR "The engine must not depend on Qt, VCG or MeshLab: "
            "${engine_file} has '${foreign_includes}'.")
    endif()
endforeach()
