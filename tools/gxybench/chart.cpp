// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/chart.h"

#include <vtkAxis.h>
#include <vtkChartXY.h>
#include <vtkContext2D.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlotPoints.h>
#include <vtkRenderer.h>
#include <vtkSVGContextDevice2D.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkXMLDataElement.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/comm/error.h"

namespace gxy::bench {
namespace {

/// Colours that the colour-blind can tell apart, too (Okabe and Ito).
constexpr std::array<std::array<unsigned char, 3>, 7> kColors{
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {86, 180, 233}, {230, 159, 0}, {0, 0, 0}}};
constexpr std::array kMarkers{vtkPlotPoints::CIRCLE, vtkPlotPoints::SQUARE, vtkPlotPoints::DIAMOND,
                              vtkPlotPoints::PLUS, vtkPlotPoints::CROSS};

bool drawable(double v) { return v > 0 && std::isfinite(v); }

/// An axis that takes the logarithms itself and scales them to about pixels, because VTK's SVG stretches
/// markers and dashes as it does the axes.
struct Axis {
  double low = INFINITY, high = 0, pixels = 1;

  void extend(double v) { low = std::min(low, v), high = std::max(high, v); }
  /// Leaves a margin around the values that it was extended by, so that it covers a decade at least, and room
  /// for `covered` pixels more.
  void finish(double length, double covered) {
    if (high == 0) low = 0.1, high = 1;
    const double margin = std::max(1.4, std::sqrt(10 * low / high));
    low /= margin, high *= margin;
    high *= std::pow(high / low, covered / (length - covered));
    pixels = length;
  }
  double at(double v) const { return pixels * std::log(v / low) / std::log(high / low); }
};

vtkSmartPointer<vtkTable> tableOf(const Curve& curve, const Axis& xAxis, const Axis& yAxis) {
  const auto table = vtkSmartPointer<vtkTable>::New();
  const vtkNew<vtkDoubleArray> x, y;
  x->SetName("x");
  y->SetName(curve.name.c_str());
  for (size_t i = 0; i < curve.x.size(); i++)
    if (drawable(curve.x[i]) && drawable(curve.y[i])) {
      x->InsertNextValue(xAxis.at(curve.x[i]));
      y->InsertNextValue(yAxis.at(curve.y[i]));
    }
  table->AddColumn(x);
  table->AddColumn(y);
  return table;
}

/// Puts ticks at powers of ten, and at 2 and 5 between them if there are few.
void setAxis(vtkAxis* axis, const Axis& range, const std::string& title) {
  const bool few = range.high / range.low < 300;
  const vtkNew<vtkDoubleArray> places;
  const vtkNew<vtkStringArray> names;
  for (int decade = int(std::floor(std::log10(range.low))); decade <= std::log10(range.high); decade++)
    for (double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10, decade);
      if (value < range.low || value > range.high || (factor > 1 && !few)) continue;
      std::ostringstream name;
      name << value;
      places->InsertNextValue(range.at(value));
      names->InsertNextValue(name.str());
    }
  axis->SetTitle(title);
  axis->SetBehavior(vtkAxis::FIXED);
  axis->SetRange(0, range.pixels);
  axis->SetCustomTickPositions(places, names);
}

void addCurve(vtkChartXY* chart, vtkTable* table, size_t index) {
  const bool alone = table->GetNumberOfRows() == 1;
  auto* plot = vtkPlotPoints::SafeDownCast(chart->AddPlot(alone ? vtkChart::POINTS : vtkChart::LINE));
  plot->SetInputData(table, 0, 1);
  const auto& c = kColors[index % kColors.size()];
  plot->SetColor(c[0], c[1], c[2], 255);
  plot->SetWidth(1.5f);
  plot->SetMarkerStyle(kMarkers[index % kMarkers.size()]);
  plot->SetMarkerSize(8);
}

void addLine(vtkChartXY* chart, vtkTable* table) {
  vtkPlot* plot = chart->AddPlot(vtkChart::LINE);
  plot->SetInputData(table, 0, 1);
  plot->SetColor(110, 110, 110, 255);
  plot->SetWidth(1);
  plot->GetPen()->SetLineType(vtkPen::DASH_LINE);
}

/// Removes clip rectangles. VTK means them in coordinates before a group's transform, SVG in those behind it.
/// Nothing reaches beyond the axes here.
void removeClips(vtkXMLDataElement* element) {
  element->RemoveAttribute("clip-path");
  for (int i = 0; i < element->GetNumberOfNestedElements(); i++) removeClips(element->GetNestedElement(i));
}

/// Draws the scene into an SVG document. VTK's own exporter needs a render window, and with it a display.
std::string svgOf(vtkContextScene* scene, int width, int height) {
  const vtkNew<vtkXMLDataElement> root, definitions, drawing;
  root->SetName("svg");
  root->SetAttribute("xmlns", "http://www.w3.org/2000/svg");
  root->SetAttribute("xmlns:xlink", "http://www.w3.org/1999/xlink");
  root->SetAttribute("viewBox", ("0 0 " + std::to_string(width) + " " + std::to_string(height)).c_str());
  root->SetIntAttribute("width", width);
  root->SetIntAttribute("height", height);
  definitions->SetName("defs");
  drawing->SetName("g");
  drawing->SetAttribute("fill", "none");  // for what VTK draws only as lines
  root->AddNestedElement(definitions);
  root->AddNestedElement(drawing);

  const vtkNew<vtkSVGContextDevice2D> device;
  device->SetSVGContext(drawing, definitions);
  // The window is asked only for its size and resolution. This kind of window opens no display and no OpenGL
  // context by itself.
  const vtkNew<vtkGenericOpenGLRenderWindow> window;
  const vtkNew<vtkRenderer> renderer;
  window->SetSize(width, height);
  window->AddRenderer(renderer);
  device->Begin(renderer);
  const vtkNew<vtkContext2D> painter;
  painter->Begin(device);
  scene->Paint(painter);
  painter->End();
  device->GenerateDefinitions();
  removeClips(drawing);
  std::ostringstream text;
  root->PrintXML(text, vtkIndent());
  return text.str();
}

}  // namespace

void writeChart(const std::string& path, const Chart& what) {
  Axis x, y;
  for (const Curve& curve : what.curves)
    for (size_t i = 0; i < curve.x.size(); i++)
      if (drawable(curve.x[i]) && drawable(curve.y[i])) x.extend(curve.x[i]), y.extend(curve.y[i]);
  if (what.line > 0) y.extend(what.line);
  const double legend = 12 + 17 * double(what.curves.size() + 1);
  x.finish(what.width - 80, 0);  // about the width that titles and labels leave
  y.finish(what.height - 60, std::min(legend, 0.4 * what.height));

  const vtkNew<vtkChartXY> chart;
  const vtkNew<vtkContextScene> scene;
  scene->SetGeometry(what.width, what.height);
  scene->AddItem(chart);
  chart->SetTitle(what.title);
  chart->SetShowLegend(true);
  setAxis(chart->GetAxis(vtkAxis::BOTTOM), x, what.xLabel);
  setAxis(chart->GetAxis(vtkAxis::LEFT), y, what.yLabel);
  for (size_t i = 0; i < what.curves.size(); i++) {
    const auto table = tableOf(what.curves[i], x, y);
    if (table->GetNumberOfRows() > 0) addCurve(chart, table, i);
  }
  if (what.line > 0) addLine(chart, tableOf({what.lineName, {x.low, x.high}, {what.line, what.line}}, x, y));
  const std::string svg = svgOf(scene, what.width, what.height);
  std::ofstream out(path);
  out << svg;
  if (!out.flush()) throw Error(path + ": cannot be written");
}

}  // namespace gxy::bench
