// SPDX-License-Identifier: Apache-2.0
//
// Made tiles.{blosc,active,plainzip}.vdb and half.none.vdb: the tree of ../tiles/make_tiles.cc and grids that are
// listed, but refused, in every compression there is. Needs OpenVDB (Debian: libopenvdb-dev libboost-dev); not part of
// the build.
//   g++ -std=c++17 -O1 make_vdb.cc -lopenvdb -ltbb -lImath -o make_vdb
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

using openvdb::Coord;

static openvdb::FloatGrid::Ptr make_tiles(const char* name) {
    auto grid = openvdb::FloatGrid::create(0.125f);
    auto& tree = grid->tree();
    grid->setName(name);
    tree.addTile(3, Coord(-4096, 0, 0), 0.5f, true);      // 4096^3, active
    tree.addTile(3, Coord(0, -8192, 4096), 0.75f, false); // 4096^3, inactive, not the background
    tree.addTile(2, Coord(128, 256, 384), 1.25f, true);   // 128^3
    tree.addTile(2, Coord(256, 256, 384), 2.5f, false);
    tree.addTile(1, Coord(0, 8, 16), 3.0f, true);         // 8^3
    tree.addTile(1, Coord(8, 8, 16), -1.5f, false);
    for (int i = 0; i < 300; i++) { // two leaves' worth of voxels on a crooked line, some at negative coordinates
        Coord at(i % 7 - 3, (i * 3) % 11 - 5, (i * 5) % 13 - 20);
        tree.setValue(at, 0.01f * float(i + 1));
    }
    tree.setValueOff(Coord(-1, -1, -20), 9.0f); // inactive voxels keep what they hold
    openvdb::math::Mat4d m(0.5, 0.25, 0.0, 0.0, -0.5, 1.0, 0.125, 0.0, 0.0, 0.0625, 2.0, 0.0, 10.0, -20.0, 30.5, 1.0);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    return grid;
}

static void write(const char* file, uint32_t compression, const openvdb::GridPtrVec& grids) {
    openvdb::io::File out(file);
    out.setCompression(compression);
    out.write(grids);
}

int main() {
    openvdb::initialize();
    auto tiles = make_tiles("tiles"), half = make_tiles("tiles_half");
    half->setSaveFloatAsHalf(true);
    auto empty = openvdb::FloatGrid::create(-2.0f);
    empty->setName("empty");
    empty->setGridClass(openvdb::GRID_LEVEL_SET);
    auto whole = openvdb::DoubleGrid::create(0.0);
    whole->setName("double");
    whole->tree().setValue(Coord(1, 2, 3), 4.0);
    auto mask = openvdb::MaskGrid::create();
    mask->setName("mask");
    mask->tree().setValueOn(Coord(1, 2, 3));
    auto twin = openvdb::FloatGrid::create(), other = openvdb::FloatGrid::create();
    twin->setName("twin");
    other->setName("twin");
    auto frustum = openvdb::FloatGrid::create();
    frustum->setName("frustum");
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0, 0, 0), openvdb::Vec3d(10, 10, 10)), 0.5, 4.0, 0.1));
    auto shared = tiles->copy(); // the same tree, another transform: written as an instance
    shared->setName("instance");
    shared->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    // inactive values are background and its negative
    auto sphere = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(9.0f, openvdb::Vec3f(33, 34, 35), 1.0f, 2.0f);
    sphere->setName("sphere");
    sphere->setGridClass(openvdb::GRID_UNKNOWN); // OpenVDB leaves zip out for level sets
    const openvdb::GridPtrVec all = {tiles, half, empty, whole, mask, twin, other, frustum, shared};
    write("tiles.blosc.vdb", openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK, all);
    write("tiles.active.vdb", openvdb::io::COMPRESS_ACTIVE_MASK, {tiles, half, sphere});
    write("tiles.plainzip.vdb", openvdb::io::COMPRESS_ZIP, {tiles, sphere});
    auto one = openvdb::FloatGrid::create(0.0f);
    one->setName("one");
    one->setGridClass(openvdb::GRID_FOG_VOLUME);
    one->setSaveFloatAsHalf(true);
    one->tree().setValue(Coord(-3, 5, 7), 0.5f);
    auto moved = openvdb::math::Transform::createLinearTransform();
    moved->preScale(openvdb::Vec3d(0.5, 0.25, 2));
    moved->postTranslate(openvdb::Vec3d(10, -20, 30.5));
    one->setTransform(moved);
    write("half.none.vdb", openvdb::io::COMPRESS_NONE, {one});
    return 0;
}
