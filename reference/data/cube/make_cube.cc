// SPDX-License-Identifier: Apache-2.0
//
// Makes cube.zip.nvdb: 8^3 active voxels of value 1, lattice points (-3,-3,-3) to (4,4,4), voxel 1/8, lattice point
// (0,0,0) at world (7/16, 7/16, 7/16): with cell centring it fills the unit cube.
//   c++ -std=c++17 make_cube.cc -o make_cube -DNANOVDB_USE_OPENVDB -DNANOVDB_USE_ZIP -lopenvdb -ltbb -lImath-3_1 -lz && ./make_cube cube.zip.nvdb
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>

int main(int argc, char **argv) {
    if (argc != 2) return 2;
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    auto transform = openvdb::math::Transform::createLinearTransform(0.125);
    transform->postTranslate(openvdb::Vec3d(7.0 / 16.0));
    grid->setTransform(transform);
    grid->fill(openvdb::CoordBBox(openvdb::Coord(-3), openvdb::Coord(4)), 1.0f, true);
    grid->tree().voxelizeActiveTiles();
    nanovdb::io::writeGrid(argv[1], nanovdb::openToNanoVDB(*grid), nanovdb::io::Codec::ZIP);
    return 0;
}
