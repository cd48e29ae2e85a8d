#include <gtest/gtest.h>

#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;

TEST(SessionFileLaw, TheDivisionIntoChunksDoesNotChangeTheTicks) {
  TemporaryFolder folder;
  Random random(41);
  for (int round = 0; round < 12; ++round) {
    const auto ticks = random_ticks(random.engine() % 3000, 500 + static_cast<std::uint64_t>(round));
    SessionHeader header = some_header();
    header.servo_rate = round % 2 ? 1000 : 4000;
    {
      SessionWriter writer(folder / "s.h5", header);
      for (std::size_t i = 0; i < ticks.size();) {
        const std::size_t n = std::min<std::size_t>(1 + random.engine() % 700, ticks.size() - i);
        writer.append(std::span(ticks).subspan(i, n));
        if (random.engine() % 3 == 0) writer.flush();  // writes a chunk in parts
        i += n;
      }
      ASSERT_TRUE(writer.finish({}));
    }
    const SessionReader reader(folder / "s.h5");
    ASSERT_EQ(reader.tick_count(), ticks.size());
    for (std::uint64_t first = 0; first < ticks.size(); first += 611) {
      const auto piece = reader.ticks(first, 611);
      for (std::size_t i = 0; i < piece.size(); ++i) ASSERT_TRUE(same_for_replay(piece[i], ticks[first + i]));
    }
  }
}

}  // namespace
}  // namespace typodont::session
