// Undoes and redoes all strokes of a volume, and compares it with what it was after each stroke.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::test {

/// `hashes` and `contents`: of the volume before the first stroke and after each one. `read(volume)` returns a content.
template <class Content, class Read>
void expect_undone_and_redone(haptics::TissueVolume& volume, const std::vector<std::uint64_t>& hashes,
                              const std::vector<Content>& contents, const Read& read) {
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = hashes.size() - 1; i-- > 0;) {
      ASSERT_TRUE(volume.undo());
      EXPECT_EQ(volume.hash(), hashes[i]);
      EXPECT_TRUE(read(volume) == contents[i]);
    }
    for (std::size_t i = 1; i < hashes.size(); ++i) {
      ASSERT_TRUE(volume.redo());
      EXPECT_EQ(volume.hash(), hashes[i]);
      EXPECT_TRUE(read(volume) == contents[i]);
    }
  }
}

}  // namespace typodont::test
