// The one-way street: data flows scene -> structure -> device -> rays -> image -> measure, includes point only backwards.
// This file holds the table of who may include whom, and checks every #include "..." against it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

const fs::path root = RAIG_SOURCE_DIR;

/// Who may include whom; a folder may always include itself. "shaders" means the files right there, not its folders.
const std::map<std::string, Names> allowedIncludes = {
    {"host/base", {"shaders/shared"}},
    {"host/scene", {"host/base", "shaders/shared"}},
    {"host/structures", {"host/base", "shaders/shared"}},
    {"host/device", {"host/base", "shaders/shared"}},
    {"host/rays",
     {"host/base", "host/scene", "host/structures", "host/device", "shaders", "shaders/shared", "shaders/structures"}},
    {"host/reference", {"host/base", "host/scene"}},  // the oracle shares no code with what it judges
    {"host/image", {"host/base"}},
    {"host/measure",
     {"host/base", "host/scene", "host/structures", "host/device", "host/rays", "host/reference", "host/image",
      "shaders/shared"}},
    {"host/app",
     {"host/base", "host/scene", "host/structures", "host/device", "host/rays", "host/reference", "host/image",
      "host/measure", "shaders/shared"}},
    {"shaders/shared", {}},
    {"shaders/structures", {"shaders/shared"}},
    {"shaders", {"shaders/shared", "shaders/structures"}},
};

/// Headers that the build writes, and the folder whose they are.
const std::map<std::string, std::string> generatedFiles = {
    {"all_structures.hpp", "host/structures"},  // the headers of registry.def's lines
    {"walks.def", "host/rays"},                 // the files of shaders/structures/
    {"ray_query.h", "host/measure"},            // the SPIR-V of shaders/ray_query.glsl
};

/// Files that may include less than their folder.
const std::map<std::string, Names> narrowerIncludes = {
    {"host/rays/npy.hpp", {"host/base"}},  // a file format, which knows nothing of rays
    {"host/rays/npy.cpp", {"host/base"}},
};

const Names topLevel = {".ci",     ".clang-format", ".gitignore", "CMakeLists.txt", "CMakePresets.json",
                        "LICENSE", "README.md",     "assets",     "host",           "run",
                        "shaders", "tests"};

/// Names in the text's lines of the form #include "name".
std::vector<std::string> quotedIncludes(const std::string& text) {
    std::vector<std::string> names;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        char hash = 0, quote = 0;
        std::string directive, name;
        if (!(words >> hash) || hash != '#' || !(words >> directive)) continue;
        if (directive.starts_with("include\"")) names.push_back(directive.substr(8, directive.size() - 9));
        if (directive != "include" || !(words >> quote) || quote != '"') continue;
        if (std::getline(words, name, '"')) names.push_back(name);
    }
    return names;
}

/// The folder that `name` means: "scene/scene.hpp" is in host/scene, "shared/rays.glsl" in shaders/shared. Like the
/// compilers, it looks under host/ first. Nothing if the file is in neither.
std::optional<std::string> folderOf(const std::string& name, const std::function<bool(const std::string&)>& exists) {
    if (const auto generated = generatedFiles.find(name); generated != generatedFiles.end()) return generated->second;
    std::string file = name;
    if (const size_t at = file.find("@STRUCTURE@"); at != file.npos) file.replace(at, 11, "brute");  // of trace.comp.in
    for (const std::string base : {"host/", "shaders/"})
        if (exists(base + file)) return fs::path(base + file).parent_path().string();
    return std::nullopt;
}

/// What is wrong with the includes of `file` (relative to the top level), one line each.
std::vector<std::string> includeFaults(const std::string& file, const std::string& text,
                                       const std::function<bool(const std::string&)>& exists) {
    const std::string folder = fs::path(file).parent_path().string();
    const auto rule = allowedIncludes.find(folder);
    if (rule == allowedIncludes.end()) return {file + " is in a folder that the design does not have"};
    const auto narrower = narrowerIncludes.find(file);

    std::vector<std::string> faults;
    for (const std::string& name : quotedIncludes(text)) {
        const std::optional<std::string> target = folderOf(name, exists);
        const Names& allowed = narrower != narrowerIncludes.end() ? narrower->second : rule->second;
        if (!target)
            faults.push_back(file + " includes \"" + name + "\", which is no file under host/ or shaders/");
        else if (*target != folder && !allowed.contains(*target))
            faults.push_back(file + " includes \"" + name + "\": " + folder + " must not know of " + *target);
    }
    return faults;
}

bool isInTree(const std::string& file) { return fs::is_regular_file(root / file); }

std::string contents(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The top level's tracked entries; those that lie there, but for build folders, where git does not know.
Names topLevelEntries() {
    Names entries;
    const std::string command = "git -C '" + root.string() + "' ls-files -z 2>/dev/null";
    if (FILE* const pipe = ::popen(command.c_str(), "r")) {
        std::string name;
        for (int c; (c = std::fgetc(pipe)) != EOF;) {
            if (c != '\0') {
                name += static_cast<char>(c);
            } else {
                entries.insert(name.substr(0, name.find('/')));
                name.clear();
            }
        }
        ::pclose(pipe);
    }
    if (!entries.empty()) return entries;
    for (const fs::directory_entry& entry : fs::directory_iterator(root))
        if (entry.path().filename() != "build" && entry.path().filename() != ".git") entries.insert(entry.path().filename());
    return entries;
}

TEST(Layers, IncludesPointBackwardsAlongTheStreet) {
    size_t files = 0, includes = 0;
    for (const char* const tree : {"host", "shaders"}) {
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / tree)) {
            if (!entry.is_regular_file() || entry.path().extension() == ".part") continue;
            const std::string file = fs::relative(entry.path(), root).generic_string();
            const std::string text = contents(entry.path());
            for (const std::string& fault : includeFaults(file, text, isInTree)) ADD_FAILURE() << fault;
            ++files;
            includes += quotedIncludes(text).size();
        }
    }
    EXPECT_GT(files, 20u);
    EXPECT_GT(includes, 40u) << "the check finds no includes, so it checks nothing";
}

TEST(Layers, TopLevelHoldsOnlyWhatTheDesignNames) {
    for (const std::string& entry : topLevelEntries()) EXPECT_TRUE(topLevel.contains(entry)) << entry;
    for (const std::string& entry : topLevel) EXPECT_TRUE(fs::exists(root / entry)) << entry;
}

TEST(Layers, LibrariesAreLinkedAlongTheStreet) {
    // raig_folder(NAME USES...) in CMakeLists.txt must not let in what the table keeps out.
    std::istringstream lines(contents(root / "CMakeLists.txt"));
    size_t folders = 0;
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("raig_folder(")) continue;
        std::istringstream words(line.substr(12, line.find(')') - 12));
        std::string name, used;
        words >> name;
        ASSERT_TRUE(allowedIncludes.contains("host/" + name)) << line;
        while (words >> used) EXPECT_TRUE(allowedIncludes.at("host/" + name).contains("host/" + used)) << line;
        ++folders;
    }
    EXPECT_GE(folders, 8u);
}

// ---- The checker itself, on violations planted in text -------------------------------------------------------------------

/// The faults of `file` holding one include, in a tree where everything named below exists.
size_t faultsOf(const std::string& file, const std::string& text) {
    static const Names tree = {"host/base/box.hpp",      "host/scene/scene.hpp",      "host/structures/bvh.hpp",
                               "host/device/device.hpp", "host/rays/tracer.hpp",      "host/reference/reference.hpp",
                               "host/image/image.hpp",   "host/measure/compare.hpp",  "host/app/options.hpp",
                               "shaders/intersect.glsl", "shaders/shared/rays.glsl",  "shaders/structures/bvh.glsl",
                               "shaders/structures/brute.glsl"};
    return includeFaults(file, text, [](const std::string& name) { return tree.contains(name); }).size();
}

TEST(LayersChecker, FindsPlantedViolations) {
    EXPECT_EQ(faultsOf("host/base/a.cpp", "#include \"scene/scene.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/structures/a.cpp", "#include \"scene/scene.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/structures/a.cpp", "#include \"structures/bvh.glsl\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/device/a.cpp", "#include \"rays/tracer.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/reference/a.cpp", "#include \"rays/tracer.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/reference/a.cpp", "#include \"shared/rays.glsl\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/device/a.cpp", "#include \"all_structures.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/image/a.cpp", "#include \"measure/compare.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/measure/a.cpp", "#include \"app/options.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/rays/npy.cpp", "#include \"scene/scene.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("shaders/shared/a.glsl", "#include \"intersect.glsl\"\n"), 1u);
    EXPECT_EQ(faultsOf("shaders/structures/a.glsl", "#include \"intersect.glsl\"\n"), 1u);
    EXPECT_EQ(faultsOf("shaders/a.comp", "#include \"base/box.hpp\"\n"), 1u);
}

TEST(LayersChecker, FindsEveryViolationHoweverItIsWritten) {
    const std::string text = "// why\n  #  include   \"scene/scene.hpp\"  // comment\n#include\"rays/tracer.hpp\"\n";
    EXPECT_EQ(faultsOf("host/base/a.cpp", text), 2u);
    EXPECT_EQ(faultsOf("host/base/a.cpp", "#include \"../scene/scene.hpp\"\n"), 1u) << "paths start at host/ or shaders/";
    EXPECT_EQ(faultsOf("host/base/a.cpp", "#include \"nowhere.hpp\"\n"), 1u);
    EXPECT_EQ(faultsOf("host/utils/a.cpp", ""), 1u) << "a folder of its own invention";
    EXPECT_EQ(faultsOf("host/scene/gltf/a.cpp", ""), 1u);
}

TEST(LayersChecker, AcceptsWhatTheTableAllows) {
    EXPECT_EQ(faultsOf("host/base/a.cpp", "#include \"base/box.hpp\"\n#include <vector>\n// #include \"x.hpp\"\n"), 0u);
    EXPECT_EQ(faultsOf("host/rays/a.cpp", "#include \"scene/scene.hpp\"\n#include \"intersect.glsl\"\n"), 0u);
    EXPECT_EQ(faultsOf("host/structures/a.hpp", "#include \"shared/rays.glsl\"\n"), 0u);
    EXPECT_EQ(faultsOf("host/app/a.cpp", "#include \"measure/compare.hpp\"\n#include \"structures/bvh.hpp\"\n"), 0u);
    EXPECT_EQ(faultsOf("shaders/a.comp", "#include \"structures/bvh.glsl\"\n#include \"shared/rays.glsl\"\n"), 0u);
    EXPECT_EQ(faultsOf("shaders/trace.comp.in", "#include \"structures/@STRUCTURE@.glsl\"\n"), 0u);
}

}  // namespace
