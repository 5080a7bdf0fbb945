// A Qt widget that shows a model without OpenGL: drag to turn it, click to ask what is there.
//
//     viewer MODEL [--grab OUT.png]
//
// Pictures are drawn into the memory of a QImage, in the window's own pixel format: nothing is copied. While nothing moves they are
// drawn again, better, whenever the event loop has nothing else to do.

#include "../overcoat.hpp"

#include <QApplication>
#include <QImage>
#include <QMouseEvent>
#include <QPainter>
#include <QTimer>
#include <QWidget>

#include <functional>
#include <cmath>
#include <cstdio>
#include <cstring>

using overcoat_cpp::Renderer;

class View : public QWidget {
    Renderer renderer;
    uint64_t world = 0;
    overcoat_camera camera{};
    QImage image;
    QPoint last, pressed;
    QTimer idle;

    overcoat_picture picture() const {
        overcoat_picture own;
        OVERCOAT_INIT(own);
        own.width = uint32_t(image.width());
        own.height = uint32_t(image.height());
        own.quality = OVERCOAT_QUALITY_GOOD;
        own.settings = "{\"background\": \"#383a3e\", \"ground\": \"shadow\"}";
        own.work_budget = 30000000;
        return own;
    }

    overcoat_target target() {
        overcoat_target own;
        OVERCOAT_INIT(own);
        own.format = OVERCOAT_XRGB8;  // QImage::Format_RGB32
        own.pixels = image.bits();
        own.length = size_t(image.sizeInBytes());
        own.stride = size_t(image.bytesPerLine());
        return own;
    }

    void redraw() {
        const auto asked = picture();
        const auto into = target();
        renderer.check(overcoat_render(renderer, world, &camera, &asked, &into, nullptr));
        idle.start(0);
        update();
    }

    // Goes around what the camera looks at.
    void turn(float right, float up) {
        float back[3];
        for (int k = 0; k < 3; k++) back[k] = camera.eye[k] - camera.target[k];
        const float distance = std::sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
        const float yaw = std::atan2(back[0], back[2]) + right;
        const float pitch = std::fmax(-1.5f, std::fmin(1.5f, std::asin(back[1] / distance) + up));
        camera.eye[0] = camera.target[0] + distance * std::cos(pitch) * std::sin(yaw);
        camera.eye[1] = camera.target[1] + distance * std::sin(pitch);
        camera.eye[2] = camera.target[2] + distance * std::cos(pitch) * std::cos(yaw);
    }

protected:
    void resizeEvent(QResizeEvent *) override {
        image = QImage(size() * devicePixelRatio(), QImage::Format_RGB32);
        image.setDevicePixelRatio(devicePixelRatio());
        redraw();
    }
    void paintEvent(QPaintEvent *) override { QPainter(this).drawImage(0, 0, image); }
    void mousePressEvent(QMouseEvent *event) override { last = pressed = event->pos(); }
    void mouseMoveEvent(QMouseEvent *event) override {
        const QPoint by = event->pos() - last;
        last = event->pos();
        turn(-3.14f * by.x() / height(), 3.14f * by.y() / height());
        redraw();
    }
    void mouseReleaseEvent(QMouseEvent *event) override {
        if (event->pos() != pressed) return;
        overcoat_hit hit;
        OVERCOAT_INIT(hit);
        const auto asked = picture();
        const double scale = devicePixelRatio();
        const auto status = overcoat_pick(renderer, world, &camera, &asked, uint32_t(pressed.x() * scale), uint32_t(pressed.y() * scale), &hit);
        if (status == OVERCOAT_OK && hit.instance) std::printf("triangle %u, %.3f m away\n", hit.triangle, double(hit.depth));
        else std::printf("nothing\n");
        std::fflush(stdout);
    }

public:
    explicit View(const char *path) {
        renderer.check(overcoat_world_new(renderer, &world));
        uint64_t model = 0;
        renderer.check(overcoat_load_file(renderer, world, path, nullptr, nullptr, nullptr, &model));
        OVERCOAT_INIT(camera);
        renderer.check(overcoat_frame(renderer, world, nullptr, 4.0f / 3.0f, &camera));
        setWindowTitle(path);
        resize(640, 480);
        idle.setSingleShot(true);
        connect(&idle, &QTimer::timeout, this, [this] {
            bool drawn = false;
            const auto asked = picture();
            const auto into = target();
            renderer.check(overcoat_refine(renderer, world, &camera, &asked, &into, &drawn, nullptr));
            update();
            if (drawn) idle.start(0);
            else emitFinal();
        });
    }
    std::function<void()> onFinal;
    void emitFinal() {
        if (onFinal) onFinal();
    }
};

int main(int count, char **arguments) {
    QApplication application(count, arguments);
    if (count != 2 && !(count == 4 && std::strcmp(arguments[2], "--grab") == 0)) {
        std::fprintf(stderr, "usage: viewer MODEL [--grab OUT.png]\n");
        return 2;
    }
    try {
        View view(arguments[1]);
        if (count == 4) {
            // What is on the widget when nothing is better.
            view.onFinal = [&] {
                const bool saved = view.grab().save(arguments[3]);
                application.exit(saved ? 0 : 1);
            };
        }
        view.show();
        return application.exec();
    } catch (const std::exception &error) {
        std::fprintf(stderr, "viewer: %s\n", error.what());
        return 1;
    }
}
