// OpenVDB. Its library contains these functions of both types of grids, so that no file compiles them again.
#pragma once

#include <openvdb/openvdb.h>

#define TYPODONT_IN_LIBRARY(Tree)                                                                  \
  extern template openvdb::Index64 Tree::activeLeafVoxelCount() const;                             \
  extern template openvdb::Index64 Tree::activeTileCount() const;                                  \
  extern template openvdb::Index64 Tree::activeVoxelCount() const;                                 \
  extern template openvdb::Index64 Tree::inactiveLeafVoxelCount() const;                           \
  extern template openvdb::Index64 Tree::inactiveVoxelCount() const;                               \
  extern template openvdb::Index64 Tree::memUsage() const;                                         \
  extern template bool Tree::evalActiveVoxelBoundingBox(openvdb::CoordBBox&) const;                \
  extern template bool Tree::evalActiveVoxelDim(openvdb::Coord&) const;                            \
  extern template void Tree::print(std::ostream&, int) const;                                      \
  extern template void Tree::readBuffers(std::istream&, bool);                                     \
  extern template void Tree::readBuffers(std::istream&, const openvdb::CoordBBox&, bool);          \
  extern template void Tree::readNonresidentBuffers() const;                                       \
  extern template void Tree::writeBuffers(std::ostream&, bool) const;                              \
  extern template void Tree::clipUnallocatedNodes();                                               \
  extern template void openvdb::Grid<Tree>::clip(const openvdb::CoordBBox&);                       \
  extern template void openvdb::Grid<Tree>::print(std::ostream&, int) const;                       \
  extern template void openvdb::Grid<Tree>::pruneGrid(float);                                      \
  extern template void openvdb::Grid<Tree>::readBuffers(std::istream&);                            \
  extern template void openvdb::Grid<Tree>::readBuffers(std::istream&, const openvdb::CoordBBox&); \
  extern template void openvdb::Grid<Tree>::writeBuffers(std::ostream&) const
TYPODONT_IN_LIBRARY(openvdb::FloatTree);
TYPODONT_IN_LIBRARY(openvdb::Int32Tree);
#undef TYPODONT_IN_LIBRARY
