//! A frame of a scene as a drawing, seen isometrically, vertical upwards.

use super::super::drawing::{Canvas, CanvasPoint, Text, TextAlign, View};
use crate::base::Point3;
use crate::base::series::{Colour, DASHED, DOTTED};
use crate::data::scene::{
    Scene, SceneFrame, SceneObstacle, SceneRobot, SceneStation, SceneTendon, StationPose,
    between_stations_m,
};
use crate::report::style::{GREEN, GREY, GRID, HALF_CAP, INK, SMALL, SOLID, WHITE};

const TUBE: Colour = [29, 63, 87];
const CORE: Colour = [91, 159, 201];
const GLOSS: Colour = [211, 232, 245];
const FACE: Colour = [159, 196, 221];
const SIDE: Colour = [109, 157, 189];
const RIM: Colour = [45, 95, 127];
const PLATE: Colour = [138, 147, 158];
const SHADOW: Colour = [200, 206, 212];
const WALL: Colour = [184, 134, 11];
/// Taut tendons.
pub(super) const TAUT: Colour = [193, 75, 0];
/// Slack tendons.
pub(super) const SLACK: Colour = [111, 122, 134];
/// What was measured.
pub(super) const MEASURED: Colour = [160, 72, 155];
/// The path of the tip.
pub(super) const TRAIL: Colour = [0, 114, 178];

/// Largest drawn thickness of a disk over its radius: the backbone can be seen between them.
const THIN: f64 = 0.15;
/// Corners of a drawn circle.
const CORNERS: usize = 28;
/// Pieces of the backbone between two stations.
const PIECES: usize = 6;
/// Frames of the tip's path that are drawn.
const MAX_TRAIL: usize = 400;
/// Room around each place over the radius of the largest disk: the base plate is wider.
const ROOM: f64 = 1.7;
/// Size of a still picture, hundredths of an inch.
const STILL: [f64; 2] = [360.0, 270.0];

/// The last frame of a scene.
pub(super) fn still(scene: &Scene) -> Canvas {
    let mut canvas = Canvas::new(STILL[0], STILL[1]);
    let sight =
        Sight::of(std::slice::from_ref(scene), [6.0, 6.0], [STILL[0] - 12.0, STILL[1] - 40.0]);
    sight.draw(&mut canvas, scene, scene.frames.len().saturating_sub(1));
    sight.head(&mut canvas, [40.0, STILL[1] - 40.0], [STILL[0] - 96.0, STILL[1] - 14.0]);
    canvas
}

/// From where scenes are seen, and where on the canvas they are drawn.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    view: View,
    /// Upwards, to the left and along the robot: the axes x, y and z of the isometric view.
    axes: [Point3; 3],
    /// Height of the ground, metres.
    floor_m: f64,
    /// Side of a square of the ground, metres.
    step_m: f64,
    /// Corners of the ground along the second and the third axis, in squares.
    squares: [[f64; 2]; 2],
}

/// Something to be drawn, by its distance towards the reader.
type Item<'a> = (f64, Box<dyn Fn(&mut Canvas) + 'a>);

impl Sight {
    /// Sees all frames of `scenes` within a rectangle.
    pub(super) fn of(scenes: &[Scene], corner: CanvasPoint, size: [f64; 2]) -> Sight {
        let axes = scenes.first().map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], axes);
        let disks = scenes.iter().flat_map(|scene| &scene.robot.stations);
        let rim_m = disks.map(|one| one.disk_radius_m.max(2.0 * one.radius_m)).fold(0.0, f64::max);
        let places: Vec<Point3> = scenes
            .iter()
            .flat_map(|scene| scene.frames.iter().flat_map(seen))
            .map(|point| turned(&axes, point))
            .collect();
        let bounds = |axis: usize| {
            let values = || places.iter().map(|place| place[axis]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        let floor_m = bounds(0)[0] - 1.2 * rim_m;
        let step_m = 0.05;
        let squares = [1, 2].map(|axis| {
            let [low, high] = bounds(axis);
            [((low - rim_m) / step_m).floor(), ((high + rim_m) / step_m).ceil()]
        });
        let [across, along] = squares;
        let ground = across
            .iter()
            .flat_map(|y| along.iter().map(move |z| [floor_m, y * step_m, z * step_m]))
            .collect::<Vec<Point3>>();
        let reach_m = ROOM * rim_m;
        let around = places.iter().flat_map(|[x, y, z]| {
            let ends = [-reach_m, reach_m];
            ends.into_iter()
                .flat_map(move |by| [[x + by, *y, *z], [*x, y + by, *z], [*x, *y, z + by]])
        });
        let view = View::of(ground.into_iter().chain(around), corner, size, 4.0);
        Sight { view, axes, floor_m, step_m, squares }
    }

    fn at(&self, point: Point3) -> CanvasPoint {
        self.view.at(turned(&self.axes, point))
    }

    /// Towards the reader.
    fn nearness(&self, point: Point3) -> f64 {
        turned(&self.axes, point).iter().sum()
    }

    fn length(&self, length_m: f64) -> f64 {
        self.view.length(length_m)
    }

    /// Draws a frame with the path of the tip until then.
    pub(super) fn draw(&self, canvas: &mut Canvas, scene: &Scene, index: usize) {
        let Some(frame) = scene.frames.get(index) else { return };
        self.ground(canvas, frame);
        let mut items: Vec<Item> = Vec::new();
        scene.robot.obstacles.iter().for_each(|obstacle| self.obstacle(obstacle, &mut items));
        if frame.poses.len() == scene.robot.stations.len() {
            self.robot(&scene.robot, frame, &mut items);
        }
        items.sort_by(|one, other| one.0.total_cmp(&other.0));
        items.iter().for_each(|(_, draw)| draw(canvas));
        let past = &scene.frames[(index + 1).saturating_sub(MAX_TRAIL)..=index];
        let line = |points: Vec<Point3>| points.into_iter().map(|point| self.at(point)).collect();
        let measured = past.iter().filter_map(|frame| frame.measured_m.first().copied()).collect();
        let tips = past.iter().filter_map(|frame| frame.tip_m).collect();
        let (measured, tips): (Vec<CanvasPoint>, Vec<CanvasPoint>) = (line(measured), line(tips));
        canvas.line(&measured, 1.2, MEASURED, DOTTED);
        canvas.line(&tips, 1.2, TRAIL, SOLID);
        self.marks(canvas, frame);
    }

    fn ground(&self, canvas: &mut Canvas, frame: &SceneFrame) {
        let [across, along] = self.squares;
        let at = |y: f64, z: f64| self.view.at([self.floor_m, y * self.step_m, z * self.step_m]);
        let lines = |[low, high]: [f64; 2]| (low as i64..=high as i64).map(|k| k as f64);
        for y in lines(across) {
            canvas.line(&[at(y, along[0]), at(y, along[1])], 0.6, GRID, SOLID);
        }
        for z in lines(along) {
            canvas.line(&[at(across[0], z), at(across[1], z)], 0.6, GRID, SOLID);
        }
        let dropped = frame.poses.iter().map(|pose| {
            let [_, y, z] = turned(&self.axes, pose.position_m());
            self.view.at([self.floor_m, y, z])
        });
        canvas.line(&dropped.collect::<Vec<_>>(), 3.5, SHADOW, SOLID);
    }

    fn robot<'a>(
        &'a self,
        robot: &'a SceneRobot,
        frame: &'a SceneFrame,
        items: &mut Vec<Item<'a>>,
    ) {
        let sections = &frame.poses;
        let stations = &robot.stations;
        // What was measured alone has no robot.
        let (Some(first), Some(base)) = (stations.first(), sections.first()) else { return };
        let widest =
            stations.iter().map(|one| one.disk_radius_m).fold(4.0 * first.radius_m, f64::max);
        self.disk(*base, [-0.35 * widest, 0.0], 1.4 * widest, [PLATE, PLATE, INK], items);
        for (station, section) in stations.iter().zip(sections) {
            if station.disk_radius_m > 0.0 {
                let half = match station.disk_thickness_m {
                    0.0 => 0.04 * station.disk_radius_m,
                    thickness_m => 0.5 * thickness_m.min(THIN * station.disk_radius_m),
                };
                self.disk(*section, [-half, half], station.disk_radius_m, [FACE, SIDE, RIM], items);
            }
        }
        for (pair, ends) in stations.windows(2).zip(sections.windows(2)) {
            self.span(pair, ends, items);
        }
        for (tendon, tension) in
            robot.tendons.iter().zip(frame.tensions_n.iter().chain(std::iter::repeat(&1.0)))
        {
            self.tendon(tendon, sections, *tension > 0.0, items);
        }
    }

    fn disk<'a>(
        &self,
        section: StationPose,
        [from_m, to_m]: [f64; 2],
        radius_m: f64,
        [face, side, rim]: [Colour; 3],
        items: &mut Vec<Item<'a>>,
    ) {
        let circle = |height_m: f64| -> Vec<CanvasPoint> {
            let corner = |k: usize| {
                let (sin, cos) = (k as f64 * std::f64::consts::TAU / CORNERS as f64).sin_cos();
                self.at(section.place_m([radius_m * cos, radius_m * sin, height_m]))
            };
            (0..CORNERS).map(corner).collect()
        };
        let (low, high) = (circle(from_m), circle(to_m));
        let faces =
            self.nearness(section.place_m([0.0, 0.0, 1.0])) > self.nearness(section.position_m());
        let front = if faces { high.clone() } else { low.clone() };
        let outline = hull(low.into_iter().chain(high).collect());
        let middle = self.nearness(section.place_m([0.0, 0.0, 0.5 * (from_m + to_m)]));
        items.push((
            middle,
            Box::new(move |canvas| {
                canvas.area(outline.clone(), side, 0.4);
                canvas.area(front.clone(), face, 0.45);
                let closed: Vec<CanvasPoint> = front.iter().chain(front.first()).copied().collect();
                canvas.line(&closed, 0.5, rim, SOLID);
            }),
        ));
    }

    /// A piece of the backbone.
    fn span<'a>(&self, stations: &[SceneStation], ends: &[StationPose], items: &mut Vec<Item<'a>>) {
        let point = |k: usize| between_stations_m(&ends[0], &ends[1], k as f64 / PIECES as f64);
        let line: Vec<CanvasPoint> = (0..=PIECES).map(|k| self.at(point(k))).collect();
        let width = self.length(stations[0].radius_m + stations[1].radius_m).max(1.6);
        items.push((
            self.nearness(point(PIECES / 2)),
            Box::new(move |canvas| {
                canvas.line(&line, width + 1.4, TUBE, SOLID);
                canvas.line(&line, width, CORE, SOLID);
                let lit: Vec<CanvasPoint> =
                    line.iter().map(|[x, y]| [x - 0.14 * width, y - 0.14 * width]).collect();
                canvas.line(&lit, 0.3 * width, GLOSS, SOLID);
            }),
        ));
    }

    fn tendon<'a>(
        &self,
        tendon: &SceneTendon,
        sections: &[StationPose],
        taut: bool,
        items: &mut Vec<Item<'a>>,
    ) {
        let holes = tendon.holes_m.iter().zip(sections.iter().skip(tendon.first));
        let places: Vec<Point3> =
            holes.map(|([x, y], section)| section.place_m([*x, *y, 0.0])).collect();
        for pair in places.windows(2) {
            let ends = [self.at(pair[0]), self.at(pair[1])];
            let near = 0.5 * (self.nearness(pair[0]) + self.nearness(pair[1])) + 1e-6;
            items.push((
                near,
                Box::new(move |canvas| {
                    if taut {
                        canvas.line(&ends, 0.9, TAUT, SOLID);
                    } else {
                        canvas.line(&ends, 0.9, SLACK, &[2.4, 2.0]);
                    }
                }),
            ));
        }
    }

    fn obstacle<'a>(&'a self, obstacle: &'a SceneObstacle, items: &mut Vec<Item<'a>>) {
        match obstacle {
            SceneObstacle::Sphere { center_m, radius_m } => {
                let (centre, radius) = (self.at(*center_m), self.length(*radius_m));
                items.push((
                    self.nearness(*center_m),
                    Box::new(move |canvas| {
                        canvas.disc(centre, radius, WALL, 0.45);
                        canvas.disc(
                            [centre[0] - 0.3 * radius, centre[1] - 0.3 * radius],
                            0.25 * radius,
                            WHITE,
                            0.6,
                        );
                    }),
                ));
            }
            SceneObstacle::Rod { ends_m, radius_m, .. } => {
                let ends = ends_m.map(|end| self.at(end));
                let width = self.length(2.0 * radius_m);
                let near = 0.5 * ends_m.iter().map(|end| self.nearness(*end)).sum::<f64>();
                items.push((near, Box::new(move |canvas| canvas.line(&ends, width, WALL, SOLID))));
            }
            SceneObstacle::HalfSpace { normal, offset_m } => {
                let corners = wall(*normal, *offset_m, 0.12).map(|corner| self.at(corner));
                items.push((
                    f64::NEG_INFINITY,
                    Box::new(move |canvas| {
                        canvas.area(corners.to_vec(), WALL, 0.25);
                        let closed: Vec<CanvasPoint> =
                            corners.iter().chain(&corners[..1]).copied().collect();
                        canvas.line(&closed, 0.8, WALL, DASHED);
                    }),
                ));
            }
        }
    }

    fn marks(&self, canvas: &mut Canvas, frame: &SceneFrame) {
        if let Some(tip_m) = frame.tip_m {
            let tip = self.at(tip_m);
            canvas.disc(tip, 2.8, TUBE, 1.0);
            canvas.disc(tip, 1.6, GLOSS, 1.0);
        }
        if let Some(target_m) = frame.target_m {
            let [x, y] = self.at(target_m);
            canvas.line(&[[x - 7.0, y], [x + 7.0, y]], 1.2, GREEN, SOLID);
            canvas.line(&[[x, y - 7.0], [x, y + 7.0]], 1.2, GREEN, SOLID);
            let ring = (0..=CORNERS).map(|k| {
                let (sin, cos) = (k as f64 * std::f64::consts::TAU / CORNERS as f64).sin_cos();
                [x + 4.5 * cos, y + 4.5 * sin]
            });
            canvas.line(&ring.collect::<Vec<_>>(), 1.3, GREEN, SOLID);
        }
        for measured_m in &frame.measured_m {
            let [x, y] = self.at(*measured_m);
            for (size, colour) in [(5.2, WHITE), (3.8, MEASURED)] {
                let corners = vec![[x, y - size], [x + size, y], [x, y + size], [x - size, y]];
                canvas.area(corners, colour, 1.0);
            }
        }
    }

    /// Axes and the side of the ground's squares.
    pub(super) fn head(&self, canvas: &mut Canvas, triad: CanvasPoint, bar: CanvasPoint) {
        let world = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (axis, name) in world.into_iter().zip(["x", "y", "z"]) {
            self.view.arrow(canvas, triad, turned(&self.axes, axis), 20.0, name);
        }
        let words = format!("grid {:.0} mm", 1e3 * self.step_m);
        let at = [bar[0] + 40.0, bar[1] + HALF_CAP * SMALL];
        canvas.text(Text::new(words, at, SMALL, TextAlign::Centre).colour(GREY));
    }
}

/// All points of a frame.
fn seen(frame: &SceneFrame) -> Vec<Point3> {
    let poses = frame.poses.iter().map(StationPose::position_m);
    let marks = frame.tip_m.iter().chain(&frame.target_m).chain(&frame.measured_m).copied();
    poses.chain(marks).collect()
}

/// Upwards, aside and along the robot as far as that is horizontal.
fn axes(scene: &Scene) -> [Point3; 3] {
    let up = scene.robot.up;
    let base = scene.frames.iter().find_map(|frame| frame.poses.first());
    let along = base.map_or([0.0, 0.0, 1.0], |pose| pose.axes()[2]);
    let flat = |vector: Point3| {
        let height = dot(vector, up);
        unit(std::array::from_fn(|k| vector[k] - height * up[k]))
    };
    let other = if up[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let ahead = if dot(along, up).abs() < 0.99 { flat(along) } else { flat(other) };
    [up, cross(ahead, up), ahead]
}

/// Corners of the part of a plane that is nearest to the origin.
fn wall(normal: Point3, offset_m: f64, half_m: f64) -> [Point3; 4] {
    let other = if normal[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let one = unit(cross(normal, other));
    let two = cross(normal, one);
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[i, j]| {
        std::array::from_fn(|k| offset_m * normal[k] + half_m * (i * one[k] + j * two[k]))
    })
}

/// Coordinates along the axes.
fn turned(axes: &[Point3; 3], point: Point3) -> Point3 {
    axes.map(|axis| dot(axis, point))
}

fn dot(a: Point3, b: Point3) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn cross(a: Point3, b: Point3) -> Point3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(vector: Point3) -> Point3 {
    let norm = dot(vector, vector).sqrt();
    vector.map(|x| x / norm)
}

/// Convex hull (Andrew's monotone chain).
fn hull(mut points: Vec<CanvasPoint>) -> Vec<CanvasPoint> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = &CanvasPoint>| {
        let mut chain: Vec<CanvasPoint> = Vec::new();
        for point in points {
            while let [.., a, b] = chain.as_slice() {
                let turn = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
                if turn > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter());
    outline.extend(half(&mut points.iter().rev()));
    outline
}
