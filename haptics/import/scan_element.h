// The number types that voxels in scan files can have.
#pragma once

#include <cstddef>

namespace typodont::haptics::importing {

enum class Element { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat, kDouble };
std::size_t bytes_of(Element type);

}  // namespace typodont::haptics::importing
