// The tests that MATH.md and PAPER.md name are there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

std::string one_line(const std::string& text) {
    return std::regex_replace(text, std::regex("\\s+"), " ");
}

/// Every text in quotes in `text`, neighbouring ones joined as the compiler does.
std::vector<std::string> quoted(const std::string& text) {
    static const std::regex quotes("\"((?:[^\"\\\\]|\\\\.)*)\"");
    std::vector<std::string> found;
    for (std::sregex_iterator at(text.begin(), text.end(), quotes), end; at != end; ++at) {
        found.push_back((*at)[1]);
    }
    return found;
}

/// The names of all test cases of the tree.
std::set<std::string> test_names() {
    static const std::regex head("TEST_CASE\\(\\s*((?:\"(?:[^\"\\\\]|\\\\.)*\"\\s*)+)");
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PALPATE_SOURCE) / "tests")) {
        if (entry.path().extension() != ".cpp") continue;
        const std::string text = text_of(entry.path());
        for (std::sregex_iterator at(text.begin(), text.end(), head), end; at != end; ++at) {
            std::string name;
            for (const std::string& part : quoted((*at)[1])) name += part;
            names.insert(name);
        }
    }
    return names;
}

/// Sentences in quotes; "..." at the end stands for the rest of a name.
std::vector<std::string> cited(const fs::path& page) {
    std::vector<std::string> sentences;
    for (std::string text : quoted(one_line(text_of(page)))) {
        if (std::count(text.begin(), text.end(), ' ') < 4) continue;
        if (text.ends_with(" ...")) text.resize(text.size() - 4);
        sentences.push_back(text);
    }
    return sentences;
}

}  // namespace

TEST_CASE("every test that a page of docs names is there") {
    const std::set<std::string> names = test_names();
    REQUIRE(names.size() > 300);
    for (const char* page : {"docs/MATH.md", "docs/PAPER.md"}) {
        const std::vector<std::string> sentences = cited(fs::path(PALPATE_SOURCE) / page);
        CHECK(sentences.size() >= 5);
        for (const std::string& sentence : sentences) {
            INFO(page << ": \"" << sentence << "\"");
            const auto at = names.lower_bound(sentence);
            CHECK((at != names.end() && at->starts_with(sentence)));
        }
    }
}
