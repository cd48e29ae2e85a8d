// Tests that the files, links and options of commands that the documents name exist, and that the documents name all
// that exist.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "engine/base/utf8.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> pages() {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator("."))
    if (entry.path().extension() == ".md") found.push_back(entry.path().filename());
  for (const char* top : {"engine", "haptics", "audio", "calibration", "shaders", "assets", "docs", "tests"})
    for (auto entry = fs::recursive_directory_iterator(top); entry != fs::recursive_directory_iterator(); ++entry) {
      if (entry->path().filename() == "build") entry.disable_recursion_pending();  // what pip leaves behind
      if (entry->path().extension() == ".md") found.push_back(entry->path());
    }
  return found;
}

/// Each first group of the pattern.
std::set<std::string> all(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) found.insert((*it)[1]);
  return found;
}

TEST(Readme, EveryLinkLeadsToAFile) {
  static const std::regex link(R"(\]\(([^)#:\s]+)(#[^)]*)?\))");
  std::size_t links = 0;
  for (const fs::path& page : pages())
    for (const std::string& to : all(test::read_text(page), link)) {
      EXPECT_TRUE(fs::exists(page.parent_path() / to)) << page << ": " << to;
      ++links;
    }
  EXPECT_GT(links, 30u);
}

/// Returns the anchor that a page's heading gets: lower case, with hyphens in place of spaces, and without punctuation.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (std::size_t i = 0; i < heading.size(); ++i) {
    const auto c = static_cast<unsigned char>(heading[i]);
    if (heading.compare(i, 2, "\xE2\x80") == 0) {  // dashes, quotation marks and dots of typography
      i += 2;
    } else if (c == ' ') {
      anchor += '-';
    } else if (std::isalnum(c) || c == '-' || c == '_' || c >= 0x80) {
      anchor += static_cast<char>(std::tolower(c));
    }
  }
  return anchor;
}

TEST(Readme, EveryAnchorOfALinkIsAHeading) {
  static const std::regex link(R"(\]\(([^):\s]*#[^)\s]+)\))"), heading(R"((?:^|\n)#+ ([^\n]+))");
  std::size_t anchors = 0;
  for (const fs::path& page : pages())
    for (const std::string& to : all(test::read_text(page), link)) {
      const std::size_t hash = to.find('#');
      const fs::path target = hash == 0 ? page : page.parent_path() / to.substr(0, hash);
      std::set<std::string> there;
      for (const std::string& title : all(test::read_text(target), heading)) there.insert(anchor_of(title));
      EXPECT_TRUE(there.contains(to.substr(hash + 1))) << page << ": " << to;
      ++anchors;
    }
  EXPECT_GT(anchors, 10u);
}

TEST(Readme, TheReadmeLeadsToEveryPageForPeople) {
  // Follows the links from page to page, as a reader does.
  static const std::regex link(R"(\]\(([^)#:\s]+)(#[^)]*)?\))");
  std::set<fs::path> reached;
  std::vector<fs::path> to_read{"README.md"};
  while (!to_read.empty()) {
    const fs::path page = to_read.back().lexically_normal();
    to_read.pop_back();
    if (!reached.insert(page).second || page.extension() != ".md") continue;
    for (const std::string& to : all(test::read_text(page), link)) to_read.push_back(page.parent_path() / to);
  }
  for (const auto& entry : fs::directory_iterator("docs"))
    if (entry.path().extension() == ".md") {
      EXPECT_TRUE(reached.contains(entry.path())) << entry.path() << " is linked from nowhere";
    }
  for (const char* page : {"CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE"})
    EXPECT_TRUE(reached.contains(page)) << page;
}

TEST(Readme, EveryPathThatAPageNamesExists) {
  static const std::regex path(
      R"re([`\s(]((?:engine|haptics|audio|calibration|shaders|assets|docs|tests|cmake)/[\w./-]*\w\.[a-z]+)[`\s,.:;)])re");
  std::size_t paths = 0;
  for (const fs::path& page : pages())
    for (const std::string& name : all(test::read_text(page), path)) {
      EXPECT_TRUE(fs::exists(name) || fs::exists(page.parent_path() / name)) << page << ": " << name;
      ++paths;
    }
  EXPECT_GT(paths, 30u);
}

TEST(Readme, EverySourceOfACuttingConstantEndsWithALetterOfItsQuality) {
  static const std::regex source(R"re("source": "([^"]*)")re"), letter(R"(.*\([ABCEF]\))");
  std::size_t sources = 0;
  for (const char* folder : {"assets/materials", "assets/motors", "assets/tools"})
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::set<std::string> found = all(test::read_text(entry.path()), source);
      EXPECT_FALSE(found.empty()) << entry.path();
      for (const std::string& text : found) {
        std::istringstream clauses(text);
        for (std::string clause; std::getline(clauses, clause, ';'); ++sources)
          EXPECT_TRUE(std::regex_match(clause, letter)) << entry.path() << ": " << clause;
      }
    }
  EXPECT_GT(sources, 150u);
}

/// Returns all pages that a person wrote. The other pages are written by a command.
std::vector<fs::path> written_pages() {
  std::vector<fs::path> written = pages();
  std::erase_if(written, [](const fs::path& page) {
    return page == "docs/performance.md" || page == "docs/models.md" || page == "docs/stress.md" ||
           page == "docs/reality.md";
  });
  return written;
}

/// Returns the lines of a page that are plain text: without code, tables, headings, pictures, links to headings and
/// HTML.
std::vector<std::string> prose(const fs::path& page) {
  std::vector<std::string> lines;
  std::ifstream in(page);
  bool code = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) code = !code;
    const bool other = line.starts_with("```") || line.starts_with("|") || line.starts_with("#") ||
                       line.starts_with("![") || line.starts_with("[") || line.starts_with("<") ||
                       line.starts_with("    ");
    const bool one_word = line.find(' ', line.find_first_not_of(' ')) == std::string::npos;  // cannot be divided
    if (!code && !other && !one_word) lines.push_back(line);
  }
  return lines;
}

TEST(Readme, NoLineOfProseIsLongerThan120Characters) {
  for (const fs::path& page : written_pages())
    for (const std::string& line : prose(page)) EXPECT_LE(count_characters(line), 120) << page << ": " << line;
}

TEST(Readme, APageOfMoreThan1500WordsBeginsWithATableOfContents) {
  static const std::regex word(R"(\S+)"), own_anchor(R"(\]\((#[^)\s]+)\))");
  for (const fs::path& page : written_pages()) {
    const std::string text = test::read_text(page);
    const auto words = std::distance(std::sregex_iterator(text.begin(), text.end(), word), std::sregex_iterator());
    if (words <= 1500) continue;
    const std::string beginning = text.substr(0, 4000);
    EXPECT_GE(all(beginning, own_anchor).size(), 3u) << page << ": " << words << " words";
  }
}

TEST(Readme, EveryTypeAndFunctionThatAPageNamesIsInTheCode) {
  // Finds `CamelCase`, `name()` and `a::b`. Names of other programs with a single capital letter are not found.
  static const std::regex named(
      R"re(`((?:[a-z_]+::)*(?:[A-Z][a-z0-9]+[A-Z]\w*|[A-Za-z_]\w*\(\)|\w+::\w+)[\w:]*(?:\(\))?)`)re"),
      word(R"(([A-Za-z_]\w+))");
  std::set<std::string> known;
  for (const char* top : {"engine", "haptics", "audio", "calibration", "shaders", "tests", "cmake"})
    for (const auto& entry : fs::recursive_directory_iterator(top))
      if (entry.is_regular_file() && entry.path().extension() != ".md" && entry.file_size() < 300'000)
        known.merge(all(test::read_text(entry.path()), word));
  std::size_t names = 0;
  for (const fs::path& page : pages())
    for (std::string name : all(test::read_text(page), named)) {
      const std::string whole = name;
      if (name.ends_with("()")) name.resize(name.size() - 2);
      const std::size_t colon = name.rfind(':');
      if (colon != std::string::npos) name = name.substr(colon + 1);
      EXPECT_TRUE(known.contains(name)) << page << ": " << whole;
      ++names;
    }
  EXPECT_GT(names, 50u);
}

TEST(Readme, EveryTestThatAPageNamesExists) {
  static const std::regex title(R"(\n(?:TYPED_)?TEST\w*\((\w+),\s*(\w+))"), named(R"(\b([A-Z]\w+\.[A-Z]\w+))");
  std::set<std::string> suites, titles;
  for (const auto& entry : fs::recursive_directory_iterator("tests")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = test::read_text(entry.path());
    for (std::sregex_iterator it(text.begin(), text.end(), title), end; it != end; ++it) {
      suites.insert((*it)[1]);
      titles.insert((*it)[1].str() + "." + (*it)[2].str());
    }
  }
  std::size_t names = 0;
  for (const fs::path& page : pages())
    for (const std::string& name : all(test::read_text(page), named)) {
      if (!suites.contains(name.substr(0, name.find('.')))) continue;
      // A page may give only the beginning of the name of a test.
      const auto first = titles.lower_bound(name);
      EXPECT_TRUE(first != titles.end() && first->starts_with(name)) << page << ": " << name;
      ++names;
    }
  EXPECT_GT(names, 30u);
}

const std::regex kNamedOption(R"re((?:^|[\s`[(])(--[a-z][a-z-]*\w))re");

/// Returns the options that the commands declare.
std::set<std::string> options_of_commands() {
  static const std::regex string(R"re("((?:-\w,)?--[a-z][a-z-]+(?:,[\w-]+)*)")re"), option(R"((--[a-z][a-z-]*\w))");
  std::set<std::string> found{"--help", "--json", "--version"};
  for (const auto& entry : fs::directory_iterator("engine/app/commands"))
    for (const std::string& declared : all(test::read_text(entry.path()), string)) found.merge(all(declared, option));
  return found;
}

TEST(Readme, EveryOptionIsOneOfTheProgram) {
  const std::set<std::string> options = options_of_commands();
  EXPECT_GT(options.size(), 60u);
  for (const fs::path& page : pages()) {
    std::ifstream in(page);
    for (std::string line; std::getline(in, line);) {
      const auto names = [&](const char* program) { return line.find(program) != std::string::npos; };
      if (names("cmake") || names("ctest") || names("pkg-config") || names("pip install") || names("renew.py") ||
          names("systemctl"))
        continue;  // theirs
      for (const std::string& name : all(line, kNamedOption))
        EXPECT_TRUE(options.contains(name)) << page << ": " << name;
    }
  }
}

/// A row of a table of assets' licences.
struct Licensed {
  fs::path folder;
  std::set<std::string> files;  // names and patterns with *, from there
  std::string licence;          // the last cell
  bool covers(const fs::path& file) const {
    const std::string name = fs::relative(file, folder).string();
    return std::any_of(files.begin(), files.end(), [&](std::string pattern) {
      pattern = std::regex_replace(pattern, std::regex(R"(\.)"), R"(\.)");
      return std::regex_match(name, std::regex(std::regex_replace(pattern, std::regex(R"(\*)"), "[^/]*")));
    });
  }
};

TEST(Assets, EveryFileIsListedWithItsLicence) {
  static const std::regex row(R"(\|([^|]*`[^|]*)\|.*\|([^|]*)\|)"), quoted("`([^`]*)`");
  std::vector<Licensed> rows;
  std::vector<fs::path> files;
  std::set<fs::path> licences;
  for (const auto& entry : fs::recursive_directory_iterator("assets")) {
    const fs::path& file = entry.path();
    if (!entry.is_regular_file()) continue;
    if (file.filename().string().starts_with("LICENSE"))
      licences.insert(file);
    else if (file.filename() != "README.md")
      files.push_back(file);
    if (file.filename() != "README.md") continue;
    std::ifstream in(file);
    std::smatch cells;
    for (std::string line; std::getline(in, line);)
      if (std::regex_match(line, cells, row)) rows.push_back({file.parent_path(), all(cells[1], quoted), cells[2]});
  }
  for (const fs::path& file : files) {
    const auto covering = std::count_if(rows.begin(), rows.end(), [&](const Licensed& r) { return r.covers(file); });
    EXPECT_EQ(covering, 1) << file << ": stands in as many rows";
  }
  for (const Licensed& r : rows) {
    EXPECT_TRUE(std::any_of(files.begin(), files.end(), [&](const fs::path& f) { return r.covers(f); }))
        << *r.files.begin() << ": no such file";
    if (r.licence.find("Apache-2.0") != std::string::npos) continue;  // our own
    EXPECT_TRUE(std::regex_search(r.licence, std::regex("MIT|BSD-2-Clause|BSD-3-Clause")))
        << *r.files.begin() << ": " << r.licence;
    const std::set<std::string> texts = all(r.licence, quoted);
    EXPECT_EQ(texts.size(), 1u) << *r.files.begin() << ": the licence's own text";
    for (const std::string& text : texts) EXPECT_TRUE(fs::exists(r.folder / text)) << text;
    for (const std::string& text : texts) licences.erase(r.folder / text);
  }
  EXPECT_TRUE(licences.empty()) << *licences.begin() << ": whose?";
}

}  // namespace
}  // namespace typodont
