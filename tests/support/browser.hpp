/// A browser without a window, for tests of pages: Debian's chromium, driven over a pipe by the DevTools protocol.
#pragma once

#include <nlohmann/json.hpp>

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace raig {

/// How a page is looked at.
struct BrowserView {
    int width = 1280, height = 900;
    bool isDark = false;
    bool hasScript = true;  ///< whether the page's own scripts run
};

/// One browser with one tab and a profile of its own, all of which goes with the object. Whatever goes
/// wrong, or takes half a minute, is a std::runtime_error.
class Browser {
public:
    /// Where chromium is, if it is there.
    static std::optional<std::string> program();

    /// Requires program().
    Browser();
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;
    ~Browser();

    /// Shows a file, and waits until it and its pictures are there. Forgets complaints and requests.
    void open(const std::filesystem::path& page, const BrowserView& view);

    /// The value of a JavaScript expression; it works with the page's scripts off, too.
    nlohmann::json evaluate(const std::string& expression);

    /// Input as a person gives it, in pixels from the window's upper left corner.
    void click(double x, double y);
    void drag(double fromX, double fromY, double toX, double toY);
    /// "ArrowLeft", "ArrowRight", "Tab" or "Enter".
    void press(const std::string& key);

    /// Errors of the page since it was opened: what it threw, printed as errors, or was refused.
    const std::vector<std::string>& complaints() const { return errors; }
    /// What it asked the network or the disk for, but for itself and what is in it.
    const std::vector<std::string>& requests() const { return asked; }

    /// A PNG of all of the page.
    void screenshot(const std::filesystem::path& file);

private:
    [[noreturn]] void become(int commands, int answers) const;
    void stop();
    nlohmann::json call(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object());
    nlohmann::json receive();
    void notice(const nlohmann::json& event);
    void mouse(const char* type, double x, double y, int buttons);

    std::filesystem::path folder;
    pid_t process = -1;
    int commandPipe = -1, answerPipe = -1;
    std::string unread;
    std::string session;
    int lastCall = 0;
    std::string shown;   ///< the page's address
    std::string loaded;  ///< the load that ended last
    std::vector<std::string> errors, asked;
};

}  // namespace raig
