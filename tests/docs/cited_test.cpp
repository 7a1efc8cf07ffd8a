// The tests that MATH.md and PAPER.md name are there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
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

/// White space of any kind and length becomes one space.
std::string one_line(const std::string& text) {
    std::istringstream words(text);
    std::string line, word;
    while (words >> word) line += (line.empty() ? "" : " ") + word;
    return line;
}

/// The text in quotes that begins at `at`, a quote, with its escapes as they stand; `at` moves behind it.
std::string in_quotes(const std::string& text, std::size_t& at) {
    std::string found;
    for (++at; at < text.size() && text[at] != '"'; ++at) {
        if (text[at] == '\\') found += text[at++];
        found += text.at(at);
    }
    ++at;
    return found;
}

/// The names of all test cases of the tree; neighbouring literals joined as the compiler does.
std::set<std::string> test_names() {
    static const std::string head = "TEST_CASE(";
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PALPATE_SOURCE) / "tests")) {
        if (entry.path().extension() != ".cpp") continue;
        const std::string text = text_of(entry.path());
        for (std::size_t at = text.find(head); at != std::string::npos; at = text.find(head, at)) {
            at = text.find_first_not_of(" \n", at + head.size());
            std::string name;
            while (at < text.size() && text[at] == '"') {
                name += in_quotes(text, at);
                at = text.find_first_not_of(" \n", at);
            }
            names.insert(name);
        }
    }
    return names;
}

/// Sentences in quotes; "..." at the end stands for the rest of a name.
std::vector<std::string> cited(const fs::path& page) {
    std::vector<std::string> sentences;
    const std::string line = one_line(text_of(page));
    for (std::size_t at = line.find('"'); at != std::string::npos; at = line.find('"', at)) {
        std::string text = in_quotes(line, at);
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
