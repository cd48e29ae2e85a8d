// Passes the fuzzer's stored corpus, and randomly damaged copies of it, to every parser. Each input must be read or
// refused; nothing else may happen.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/targets.h"
#include "tests/support/campaign.h"
#include "tests/support/folder.h"

namespace typodont::test {
namespace {

std::vector<std::vector<std::byte>> corpus_of(std::string_view target) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path("tests/fuzz/corpus") / target))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::vector<std::byte>> corpus;
  for (const auto& file : files) {
    const std::string text = read_text(file);
    corpus.emplace_back(reinterpret_cast<const std::byte*>(text.data()),
                        reinterpret_cast<const std::byte*>(text.data()) + text.size());
  }
  return corpus;
}

/// Returns the bytes with changes: some bytes are replaced, cut out, doubled, or cut off at the end.
std::vector<std::byte> damaged(std::vector<std::byte> bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1)); };
  for (std::size_t k = 1 + below(4); k > 0 && !bytes.empty(); --k) {
    const std::size_t at = below(bytes.size()), length = std::min(1 + below(16), bytes.size() - at);
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at),
               last = first + static_cast<std::ptrdiff_t>(length);
    switch (below(5)) {
      case 0:
        bytes[at] = static_cast<std::byte>(random());
        break;
      case 1:
        bytes[at] ^= static_cast<std::byte>(1u << below(8));
        break;
      case 2:
        bytes.erase(first, last);
        break;
      case 3: {
        const std::vector<std::byte> piece(first, last);
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size())), piece.begin(), piece.end());
        break;
      }
      default:
        bytes.resize(at);
    }
  }
  return bytes;
}

class FuzzCorpus : public testing::TestWithParam<FuzzTarget> {};

TEST_P(FuzzCorpus, FilesAndTheirDamagedCopiesAreReadOrRefused) {
  const auto corpus = corpus_of(GetParam().name);
  ASSERT_FALSE(corpus.empty());
  std::mt19937_64 random(42);
  for (const auto& bytes : corpus) GetParam().eat(bytes);
  for (int i = 0; i < campaign(100); ++i) GetParam().eat(damaged(corpus[random() % corpus.size()], random));
}

INSTANTIATE_TEST_SUITE_P(Parsers, FuzzCorpus, testing::ValuesIn(fuzz_targets().begin(), fuzz_targets().end()),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace typodont::test
