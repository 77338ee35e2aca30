/// What the options of several commands are made of.
#pragma once

#include "app/options.hpp"

#include <charconv>
#include <optional>
#include <string_view>

namespace CLI {
class App;
class Option;
}

namespace raig {

/// The whole text as one number, or nothing. No blanks, plus sign or trailing characters. NaN and infinities are numbers.
template <class Number>
std::optional<Number> numberOf(std::string_view text) {
    Number value{};
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

/// The text as a whole number from `low` to `high`, or nothing.
std::optional<uint32_t> wholeNumber(std::string_view text, uint32_t low, uint32_t high);

/// An option that takes a number from `low` to `high`; it throws usageError for anything else.
void addWholeNumber(CLI::App& app, const std::string& name, uint32_t& value, uint32_t low, uint32_t high,
                    const std::string& description);

/// Appends a file named by its place on the command line to options.inputs.
CLI::Option* addInput(CLI::App& app, Options& options, const std::string& name, const std::string& description);

/// --output, a picture; it throws usageError for endings that no format has.
void addPictureFile(CLI::App& app, Options& options, const std::string& description, bool required);

/// --seed.
void addSeed(CLI::App& app, Options& options);

/// --device, --threads, --json and --quiet.
void addCommon(CLI::App& app, Options& options);

}  // namespace raig
